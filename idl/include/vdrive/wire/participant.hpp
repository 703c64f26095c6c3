// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/source.hpp"

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::wire {

/// Where a participant may be reached, and how it finds others. The default is loopback UDP only,
/// with multicast.
struct NetworkSettings {
  std::uint32_t domain = 0;  ///< DDS domain, 0 to 232
  std::vector<std::string>
      interfaces{};  ///< own addresses in the networks to use; empty = loopback only
  std::vector<std::string> peers{};  ///< addresses asked for participants beside multicast
  std::vector<std::string>
      discovery_servers{};     ///< such as 10.0.0.9:11811, instead of multicast; first = id 0
  bool shared_memory = false;  ///< opt-in: killed processes leave segments behind
  std::string security{};      ///< directory of the closed mode's material; empty = open
};

/// DDS could not be set up; the message names the entity and the setting.
class NetworkError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The permissions of this participant's identity do not include what was asked for.
class NotPermitted : public NetworkError {
 public:
  using NetworkError::NetworkError;
};

/// A DDS domain participant: lease 2 s, no type objects on the wire. Owns everything below it; must
/// outlive its publications and subscriptions.
class Participant {
 public:
  /// @throws NetworkError when the domain is out of range, the security material is not in order,
  ///         or DDS refuses the participant.
  Participant(const NetworkSettings& settings, const std::string& name);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// @return what its messages show as their source.
  [[nodiscard]] Source source() const noexcept;

  /// Makes everybody look at its announcement anew. The library looks once at each: whoever had no
  /// place for another participant then would not know this one until it changes.
  void announce_again();

  struct Entities;  ///< DDS objects, known inside the wire room only

  [[nodiscard]] Entities& entities() noexcept { return *entities_; }

 private:
  std::unique_ptr<Entities> entities_;
};

}  // namespace vdrive::wire
