// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "wire/wire_program.hpp"

#include <chrono>
#include <memory>

namespace vdrive::service {

/// Tests from outside whether a wire still discovers, receives and sends: as a participant of its
/// own it makes a reader and a writer anew, which the wire has to find, sends the wire a sample and
/// waits for one of its samples. Threads that exist and sockets that are open prove none of this.
class WireProbe {
 public:
  /// How long one probe waits.
  static constexpr std::chrono::seconds kPatience{2};

  /// @param program outlives this
  /// @throws wire::NetworkError
  WireProbe(wire::NetworkSettings settings, WireProgram& program);

  /// @return whether a probe came through in both directions. Takes what discovery takes, some
  ///         10 ms, and the time to the next state of the bench.
  [[nodiscard]] bool comes_through();

 private:
  WireProgram& program_;
  std::unique_ptr<wire::Participant> participant_;
};

}  // namespace vdrive::service
