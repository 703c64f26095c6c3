// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <string_view>
#include <vector>

/// The history that a bench keeps: who wrote what, and what happened around a fault.
namespace vdrive::client {

/// A write to an object of an axis, or an event between writes that affected axes.
struct AxisWrite {
  enum class Kind : std::uint8_t {
    write,
    power_cycle,      ///< of the axis
    restored,         ///< all axes were set to the state of a snapshot
    lost,             ///< older entries that the bench no longer keeps
    connection_loss,  ///< in a window: the master of the axis fell silent
  };

  /// How it reached the bench.
  enum class Means : std::uint8_t { request, frame, bench };

  Kind kind = Kind::write;
  Means means = Means::request;
  std::uint16_t axis = 0;     ///< number on its bench
  std::uint64_t tick = 0;     ///< the last tick completed before it
  std::uint64_t session = 0;  ///< 0 = from a program without a session, or from the bench
  ObjectAddress object{};
  std::int64_t value = 0;
  std::uint32_t reason = 0;  ///< of a refusal: wire reason or CiA 301 abort code; 0 = accepted
  bool is_late = false;      ///< refused because its tick had passed
};

/// One answer of Session::writes().
struct AxisWrites {
  std::vector<AxisWrite> writes{};  ///< oldest first
  std::uint64_t place = 0;          ///< of the last one: pass it to the next call to continue
  std::uint64_t tick = 0;           ///< the last tick that the bench has completed
};

/// Why a bench kept a window.
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

/// @return a text such as "fault" or "master lost".
[[nodiscard]] std::string_view to_string(WindowCause::Kind kind) noexcept;

/// A stretch of time kept in the black box of a bench: from 2 s before its first cause to 0.5 s
/// after the last, but at most 2 s after the first.
struct KeptWindow {
  std::uint64_t number = 0;
  std::uint64_t first_tick = 0;
  std::uint64_t last_tick = 0;
  bool is_open = false;               ///< still being recorded: `last_tick` is where it will end
  std::vector<WindowCause> causes{};  ///< the first ones, oldest first
  std::uint64_t more_causes = 0;      ///< the number of further causes, which are not listed
};

/// The value of an object at the beginning of a window, or after a break in it.
struct WindowValue {
  std::uint64_t tick = 0;
  std::uint16_t axis = 0;  ///< number on its bench
  ObjectAddress object{};
  std::int64_t value = 0;
};

/// A place where a window continues with a different state.
struct WindowBreak {
  enum class Kind : std::uint8_t {
    restored,  ///< all axes were set to the state of a snapshot
    jumped,    ///< the tick number jumped
    missing,   ///< what came before was not recorded
  };

  Kind kind = Kind::restored;
  std::uint64_t tick = 0;  ///< of the state after the break
};

/// An event that the bench published.
struct WindowEvent {
  std::uint64_t tick = 0;
  EventKind kind = EventKind::state_changed;
  std::uint16_t axis = 0;     ///< number on its bench, 0 = the bench
  std::uint64_t session = 0;  ///< 0 = none
  std::uint32_t code = 0;     ///< as Event::code
};

/// The contents of a window: what its axes did.
struct Window {
  KeptWindow kept;
  std::vector<Observation> samples{};  ///< one per tick; the owners of the axes are not known
  std::vector<AxisWrite> writes{};     ///< accepted or refused
  std::vector<WindowEvent> events{};
  std::vector<WindowBreak> breaks{};
  std::vector<WindowValue> values{};  ///< of all writable objects
};

}  // namespace vdrive::client
