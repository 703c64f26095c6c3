// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive_messages.h"

#include <array>
#include <cstdint>
#include <string_view>

namespace vdrive::wire {

/// A kind of event of the wire contract, and its name in logs, recordings and programs.
struct EventKindRow {
  std::uint32_t kind = 0;  ///< EVENT_...
  std::string_view name;
};

/// In the order of their numbers, which begin at 1 and have no gap.
inline constexpr auto kEventKinds = std::to_array<EventKindRow>({
    {msg::EVENT_STATE_CHANGED, "state_changed"},
    {msg::EVENT_FAULT, "fault"},
    {msg::EVENT_FAULT_RESET, "fault_reset"},
    {msg::EVENT_REFUSED, "refused"},
    {msg::EVENT_SET_POINT_IGNORED, "set_point_ignored"},
    {msg::EVENT_CONTROL_CHANGED, "control_changed"},
    {msg::EVENT_MASTER_LOST, "master_lost"},
    {msg::EVENT_TICK_OVERRUN, "tick_overrun"},
    {msg::EVENT_TICK_JUMPED, "tick_jumped"},
    {msg::EVENT_QUEUE_OVERFLOW, "queue_overflow"},
    {msg::EVENT_BENCH_CONFLICT, "bench_conflict"},
    {msg::EVENT_CLOCK_CHANGED, "clock_changed"},
    {msg::EVENT_SNAPSHOT, "snapshot"},
    {msg::EVENT_JOURNAL, "journal"},
    {msg::EVENT_SHUTDOWN, "shutdown"},
    {msg::EVENT_PARAMETERS, "parameters"},
    {msg::EVENT_WALL_CLOCK, "wall_clock"},
    {msg::EVENT_WIRE, "wire"},
    {msg::EVENT_STOPPED, "stopped"},
});

/// @return the name of an EVENT_ constant, such as "fault_reset"; "unknown" for any other number.
[[nodiscard]] constexpr std::string_view event_name(std::uint32_t kind) noexcept {
  return kind >= 1 && kind <= kEventKinds.size() ? kEventKinds[kind - 1].name : "unknown";
}

}  // namespace vdrive::wire
