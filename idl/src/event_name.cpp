// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/event_name.hpp"

#include "vdrive_messages.h"

namespace vdrive::wire {

std::string_view event_name(std::uint32_t kind) noexcept {
  switch (kind) {
    case msg::EVENT_STATE_CHANGED:
      return "state_changed";
    case msg::EVENT_FAULT:
      return "fault";
    case msg::EVENT_FAULT_RESET:
      return "fault_reset";
    case msg::EVENT_REFUSED:
      return "refused";
    case msg::EVENT_SET_POINT_IGNORED:
      return "set_point_ignored";
    case msg::EVENT_CONTROL_CHANGED:
      return "control_changed";
    case msg::EVENT_MASTER_LOST:
      return "master_lost";
    case msg::EVENT_TICK_OVERRUN:
      return "tick_overrun";
    case msg::EVENT_TICK_JUMPED:
      return "tick_jumped";
    case msg::EVENT_QUEUE_OVERFLOW:
      return "queue_overflow";
    case msg::EVENT_BENCH_CONFLICT:
      return "bench_conflict";
    case msg::EVENT_CLOCK_CHANGED:
      return "clock_changed";
    case msg::EVENT_SNAPSHOT:
      return "snapshot";
    case msg::EVENT_JOURNAL:
      return "journal";
    case msg::EVENT_WIRE:
      return "wire";
    case msg::EVENT_STOPPED:
      return "stopped";
    case msg::EVENT_PARAMETERS:
      return "parameters";
    case msg::EVENT_SHUTDOWN:
      return "shutdown";
    case msg::EVENT_WALL_CLOCK:
      return "wall_clock";
    default:
      return "unknown";
  }
}

}  // namespace vdrive::wire
