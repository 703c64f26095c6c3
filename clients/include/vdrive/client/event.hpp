// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vdrive::client {

/// What happened. The numbers are those of the wire.
enum class EventKind : std::uint32_t {
  state_changed = 1,      ///< code: new statusword
  fault = 2,              ///< code: 603Fh
  fault_reset = 3,        ///< code: 603Fh of the fault that was reset
  refused = 4,            ///< code: reason or abort code; session: whose message it was
  set_point_ignored = 5,  ///< session: of the owner
  control_changed = 6,    ///< code: the new epoch, 0 = released or taken away; session: whose
  master_lost = 7,        ///< session: that stopped sending
  tick_overrun = 8,
  tick_jumped = 9,
  queue_overflow = 10,
  bench_conflict = 11,
  clock_changed = 12,
  snapshot = 13,
  journal = 14,
  shutdown = 15,
  parameters = 16,
  wall_clock = 17,
  wire = 18,
  stopped = 19,  ///< by a session that does not own the axis; code: 6040h in force; session: whose
};

/// Whether Session::on_event begins with what the benches keep.
enum class EventHistory : std::uint8_t {
  left_out,
  kept,  ///< the last 1,024 events of each bench come first
};

/// @return such as "fault_reset"; "unknown" for a kind of a later version.
[[nodiscard]] std::string_view to_string(EventKind kind) noexcept;

/// Something that happened on a bench, see EVENT_... in docs/reference/wire.md.
struct Event {
  std::uint32_t bench = 0;
  std::uint16_t axis = 0;  ///< number on the bench; 0 = the bench, or several axes
  EventKind kind = EventKind::state_changed;
  std::uint64_t tick = 0;
  std::uint64_t session = 0;  ///< 0 = none
  std::uint32_t code = 0;
  std::uint8_t error_register = 0;  ///< of a fault: byte 2 of the EMCY message
  std::uint32_t suppressed = 0;     ///< equal events left out before this one
  std::string text;                 ///< for people
};

}  // namespace vdrive::client
