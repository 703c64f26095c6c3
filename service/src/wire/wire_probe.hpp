// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "wire/wire_program.hpp"

#include <chrono>
#include <memory>

namespace vdrive::service {

/// Tests from outside whether a wire still discovers, receives and sends: as a separate participant
/// it creates a new reader and a new writer, which the wire must discover, sends the wire a sample
/// and waits for one from it. Existing threads and open sockets would prove none of this.
///
/// With a discovery server the reader and the writer stay the same, because a server that is down
/// must not end a wire that its clients can still reach. Then only the first probe tests discovery,
/// and a probe counts as passed as long as no server has answered.
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

  /// Takes the time of discovery, some 10 ms, and the time until the next state of the bench.
  /// @return whether a probe arrived in both directions
  [[nodiscard]] bool comes_through();

 private:
  class Endpoints;

  WireProgram& program_;
  const bool depends_on_server_;
  std::unique_ptr<wire::Participant> participant_;
  std::unique_ptr<Endpoints> endpoints_;  ///< of the last probe
  bool was_found_ = false;                ///< the probe has discovered the wire at least once
};

}  // namespace vdrive::service
