// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace vdrive::client {

/// The run of a service that a call commands.
struct Target {
  BenchKey key;
  ClockMode clock_mode = ClockMode::realtime;
  std::chrono::microseconds period{1000};
  std::uint32_t status_every_ticks = 1;
  double rate = 1.0;       ///< realtime: drive time over wall time
  bool is_paused = false;  ///< drive time stands still, and so does the status stream

  [[nodiscard]] bool steps() const { return clock_mode == ClockMode::lockstep; }
};

/// @return the present run of the service of this bench.
[[nodiscard]] Target target_of(const PresentBench& bench);

/// @return the names of a bench and of an axis in messages: "bench 1", "axis 1.2".
[[nodiscard]] std::string name_of(const Target& target);
[[nodiscard]] std::string name_of(const Target& target, std::uint16_t axis);

/// @return the reason for the standstill: "bench 1 is paused: rate 0".
[[nodiscard]] std::string paused_text(const Target& target);

/// @return the message that the run of the service has ended and another one has begun.
[[nodiscard]] std::string restarted_text(const Target& target);

/// @return why a session without permission to command sent nothing.
[[nodiscard]] Outcome not_permitted(const Target& target);

/// @return why a request was refused as a whole.
/// @param what names the request, such as "read of axis 1.1"
[[nodiscard]] Outcome refusal_of(const Target& target, const msg::Reply& reply,
                                 std::string_view what);

/// @return why a command frame, or a command in it, was refused.
/// @param apply_at_tick the tick that the frame was meant for, 0 = any
[[nodiscard]] Outcome refusal_of(const Target& target, const msg::CommandReply& reply,
                                 std::uint64_t apply_at_tick);

}  // namespace vdrive::client
