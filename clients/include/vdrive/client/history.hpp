// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <string_view>
#include <vector>

/// What a bench remembers: who wrote what, and what happened around a fault.
namespace vdrive::client {

/// What somebody wrote to an object of an axis, or what happened to axes in between.
struct AxisWrite {
  enum class Kind : std::uint8_t {
    write,
    power_cycle,      ///< of the axis
    restored,         ///< all axes got the state of a snapshot
    lost,             ///< older ones that the bench does not keep any more
    connection_loss,  ///< of a window: the master of the axis fell silent
  };

  /// How it came to the bench.
  enum class Means : std::uint8_t { request, frame, bench };

  Kind kind = Kind::write;
  Means means = Means::request;
  std::uint16_t axis = 0;     ///< number on its bench
  std::uint64_t tick = 0;     ///< the last completed one before
  std::uint64_t session = 0;  ///< 0 = of a program without one, or of the bench
  ObjectAddress object{};
  std::int64_t value = 0;
  std::uint32_t reason = 0;  ///< of a refusal: of the wire, or a CiA 301 abort code; 0 = accepted
  bool is_late = false;      ///< refused, because its tick had passed
};

/// The next writes to a bench.
struct AxisWrites {
  std::vector<AxisWrite> writes{};  ///< oldest first
  std::uint64_t place = 0;          ///< of the last one: the next call goes on from there
  std::uint64_t tick = 0;           ///< the bench has completed
};

/// Why a bench has kept a window.
struct WindowCause {
  enum class Kind : std::uint8_t {
    fault,        ///< of the axis
    master_lost,  ///< the session fell silent
    stopped,      ///< the session stopped an axis that it does not own
    asked,        ///< Session::freeze_window
  };

  Kind kind = Kind::fault;
  std::uint16_t axis = 0;     ///< number on its bench, 0 = none
  std::uint32_t code = 0;     ///< of a fault: 603Fh
  std::uint64_t session = 0;  ///< 0 = none
  std::uint64_t tick = 0;     ///< the last completed one
};

/// @return such as "fault" or "master lost".
[[nodiscard]] std::string_view to_string(WindowCause::Kind kind) noexcept;

/// A stretch of time that the black box of a bench keeps: from 2 s before its first cause to 0.5 s
/// after the last, at most 2 s after the first.
struct KeptWindow {
  std::uint64_t number = 0;
  std::uint64_t first_tick = 0;
  std::uint64_t last_tick = 0;
  bool is_open = false;  ///< it is still being recorded: `last_tick` will be its last one
  std::vector<WindowCause> causes{};  ///< the first ones, oldest first
  std::uint64_t more_causes = 0;      ///< that are not among them
};

/// The value of an object at the beginning of a window, or after a break of it.
struct WindowValue {
  std::uint64_t tick = 0;
  std::uint16_t axis = 0;  ///< number on its bench
  ObjectAddress object{};
  std::int64_t value = 0;
};

/// Where a window goes on with another state.
struct WindowBreak {
  enum class Kind : std::uint8_t {
    restored,  ///< all axes got the state of a snapshot
    jumped,    ///< the number of the tick jumped
    missing,   ///< what was before was not recorded
  };

  Kind kind = Kind::restored;
  std::uint64_t tick = 0;  ///< of the state after it
};

/// What was reported to everybody.
struct WindowEvent {
  std::uint64_t tick = 0;
  EventKind kind = EventKind::state_changed;
  std::uint16_t axis = 0;     ///< number on its bench, 0 = the bench
  std::uint64_t session = 0;  ///< 0 = none
  std::uint32_t code = 0;     ///< as Event::code
};

/// What axes did in a window.
struct Window {
  KeptWindow kept;
  std::vector<Observation> samples{};  ///< of each tick; who owned the axes is not known
  std::vector<AxisWrite> writes{};     ///< accepted or refused
  std::vector<WindowEvent> events{};
  std::vector<WindowBreak> breaks{};
  std::vector<WindowValue> values{};  ///< of all objects that can be written
};

}  // namespace vdrive::client
