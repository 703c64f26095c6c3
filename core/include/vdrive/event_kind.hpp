// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vdrive {

/// Kinds of events on a bench. The numbers are those of EVENT_... on the wire
/// (docs/reference/wire.md); they start at 1 and have no gaps.
enum class EventKind : std::uint32_t {
  state_changed = 1,      ///< code: new statusword
  fault = 2,              ///< code: 603Fh
  fault_reset = 3,        ///< code: 603Fh of the fault that was reset
  refused = 4,            ///< code: reason or abort code; session: sender of the message
  set_point_ignored = 5,  ///< session: the owner
  control_changed = 6,  ///< code: the new epoch, 0 = released or taken away; session: the one that
                        ///< gained control or, for 0, lost it
  master_lost = 7,      ///< session: the one that stopped sending
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
  stopped = 19,  ///< by a session that does not own the axis; code: 6040h in force; session: sender
};

/// How an event is presented to people, in a terminal or in the log panel of a viewer.
enum class EventSeverity : std::uint8_t {
  info,     ///< as commanded or configured
  warning,  ///< something was not done, was lost, or came from elsewhere
  error,    ///< axes stop because of it, or another bench sends with the same number
};

struct EventKindRow {
  EventKind kind{};
  std::string_view name;  ///< in logs, recordings and programs
  EventSeverity severity{};
};

inline constexpr auto kEventKinds = std::to_array<EventKindRow>({
    {EventKind::state_changed, "state_changed", EventSeverity::info},
    {EventKind::fault, "fault", EventSeverity::error},
    {EventKind::fault_reset, "fault_reset", EventSeverity::info},
    {EventKind::refused, "refused", EventSeverity::warning},
    {EventKind::set_point_ignored, "set_point_ignored", EventSeverity::warning},
    {EventKind::control_changed, "control_changed", EventSeverity::info},
    {EventKind::master_lost, "master_lost", EventSeverity::error},
    {EventKind::tick_overrun, "tick_overrun", EventSeverity::warning},
    {EventKind::tick_jumped, "tick_jumped", EventSeverity::warning},
    {EventKind::queue_overflow, "queue_overflow", EventSeverity::warning},
    {EventKind::bench_conflict, "bench_conflict", EventSeverity::error},
    {EventKind::clock_changed, "clock_changed", EventSeverity::info},
    {EventKind::snapshot, "snapshot", EventSeverity::info},
    {EventKind::journal, "journal", EventSeverity::warning},
    {EventKind::shutdown, "shutdown", EventSeverity::info},
    {EventKind::parameters, "parameters", EventSeverity::info},
    {EventKind::wall_clock, "wall_clock", EventSeverity::warning},
    {EventKind::wire, "wire", EventSeverity::warning},
    {EventKind::stopped, "stopped", EventSeverity::warning},
});

/// @return the row of `kind`; nullptr for a number of a later version.
[[nodiscard]] constexpr const EventKindRow* row_of(EventKind kind) noexcept {
  const auto number = static_cast<std::size_t>(kind);
  return number >= 1 && number <= kEventKinds.size() ? &kEventKinds[number - 1] : nullptr;
}

/// @return a name such as "fault_reset"; "unknown" for a kind of a later version.
[[nodiscard]] constexpr std::string_view to_string(EventKind kind) noexcept {
  const EventKindRow* const row = row_of(kind);
  return row == nullptr ? "unknown" : row->name;
}

/// @return the severity; info for a kind of a later version.
[[nodiscard]] constexpr EventSeverity severity_of(EventKind kind) noexcept {
  const EventKindRow* const row = row_of(kind);
  return row == nullptr ? EventSeverity::info : row->severity;
}

}  // namespace vdrive
