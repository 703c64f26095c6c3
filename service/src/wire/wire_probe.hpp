// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "wire/wire_program.hpp"

#include <chrono>
#include <memory>

namespace vdrive::service {

/// Tests from outside whether a wire still discovers, receives and sends: as a participant of its
/// own it makes a new reader and a new writer, which the wire has to find, sends the wire a sample
/// and waits for one of its samples. Threads that exist and sockets that are open prove none of
/// this. With a discovery server the reader and the writer stay the same: a server that is away
/// must not end a wire that its clients still have. Then only the first probe shows discovery, and
/// while no server is there it shows nothing.
class WireProbe {
 public:
  /// How long one probe waits.
  static constexpr std::chrono::seconds kPatience{2};

  /// @param program outlives this
  /// @throws wire::NetworkError
  WireProbe(wire::NetworkSettings settings, WireProgram& program);
  ~WireProbe();
  WireProbe(const WireProbe&) = delete;
  WireProbe& operator=(const WireProbe&) = delete;

  /// @return whether a probe came through in both directions. Takes what discovery takes, some
  ///         10 ms, and the time to the next state of the bench.
  [[nodiscard]] bool comes_through();

 private:
  class Endpoints;

  WireProgram& program_;
  const bool depends_on_server_;
  std::unique_ptr<wire::Participant> participant_;
  std::unique_ptr<Endpoints> endpoints_;  ///< of the last probe
  bool was_found_ = false;                ///< the wire, once
};

}  // namespace vdrive::service
