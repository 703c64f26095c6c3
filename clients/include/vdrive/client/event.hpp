// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/event_kind.hpp"

#include <cstdint>
#include <string>

namespace vdrive::client {

using vdrive::EventKind;
using vdrive::EventSeverity;
using vdrive::severity_of;
using vdrive::to_string;

/// Whether Session::on_event starts with the events that the benches have kept.
enum class EventHistory : std::uint8_t {
  left_out,
  kept,  ///< the last 1,024 events of each bench come first
};

/// An event on a bench; see EVENT_... in docs/reference/wire.md.
struct Event {
  std::uint32_t bench = 0;
  std::uint64_t incarnation = 0;  ///< of the bench; differs for each run of its service
  std::uint16_t axis = 0;         ///< number on the bench; 0 = the bench, or several axes
  EventKind kind = EventKind::state_changed;
  std::uint64_t tick = 0;
  std::uint64_t session = 0;  ///< 0 = none
  std::uint32_t code = 0;
  std::uint8_t error_register = 0;  ///< for a fault: byte 2 of the EMCY message
  std::uint32_t suppressed = 0;     ///< equal events suppressed before this one
  std::string text;                 ///< a readable message

  friend bool operator==(const Event&, const Event&) = default;
};

}  // namespace vdrive::client
