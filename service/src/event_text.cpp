// SPDX-License-Identifier: Apache-2.0
#include "event_text.hpp"

#include "vdrive/cia402/power_state.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/service/bench_engine.hpp"
#include "vdrive/service/parameter_store.hpp"
#include "vdrive/service/realtime_driver.hpp"
#include "vdrive/service/stepper_table.hpp"
#include "vdrive/wire/conversion.hpp"
#include "wire_judge.hpp"

#include <bit>
#include <cmath>
#include <system_error>

namespace vdrive::service {
namespace {

constexpr std::size_t kLongestText = 200;

std::string who(const EventRecord& event) {
  return event.axis == 0 ? "" : "axis " + std::to_string(event.axis) + ": ";
}

std::string control_text(const EventRecord& event) {
  const std::string axes = event.axis != 0 ? "" : std::to_string(event.detail) + " axes ";
  if (event.code == 0) {
    return axes + "released by session " + hex(event.session, 16);
  }
  return axes + "controlled by session " + hex(event.session, 16) + " in epoch " +
         std::to_string(event.code);
}

std::string refusal_text(const EventRecord& event) {
  const std::string late =
      event.late_by == 0 ? "" : ", late by " + std::to_string(event.late_by) + " ticks";
  return "refused: " + wire::describe_reason(event.code) + late + " (session " +
         hex(event.session, 16) + ", number " + std::to_string(event.detail) + ")";
}

std::string clock_text(const EventRecord& event) {
  const std::string session = "session " + hex(event.session, 16);
  switch (event.code) {
    case msg::REQUEST_SET_RATE: {
      const auto rate = std::bit_cast<double>(event.detail);
      return rate == 0.0 ? "paused by " + session : "rate " + to_text(rate) + " set by " + session;
    }
    case msg::REQUEST_JOIN_CLOCK:
      return session + " joined the clock";
    default:
      break;
  }
  switch (static_cast<Parting>(event.detail)) {
    case Parting::silent:
      return session + " was taken off the clock: silent while others waited for it";
    case Parting::gone:
      return session + " was taken off the clock: its program is gone";
    default:
      return session + " left the clock";
  }
}

std::string wall_clock_text(const EventRecord& event) {
  constexpr double kMicroseconds = 1e6;
  const double offset =
      static_cast<double>(static_cast<std::int64_t>(event.detail)) / kMicroseconds;
  const std::string place = "the wall clock was stepped, it is " + to_text(std::abs(offset)) +
                            (offset < 0.0 ? " s behind" : " s ahead of");
  if (event.code == WallClockNews::kJumped) {
    return place + " drive time: the tick number jumps";
  }
  const auto seconds = static_cast<std::uint64_t>(std::abs(offset) / TickClock::kMaxSteering);
  return place + " drive time, which is steered for about " + std::to_string(seconds) + " s";
}

std::string snapshot_text(const EventRecord& event) {
  const char* const what = event.code == SnapshotNews::kTaken      ? " taken"
                           : event.code == SnapshotNews::kRestored ? " restored"
                                                                   : " dropped";
  return "snapshot " + std::to_string(event.detail) + what;
}

std::string journal_text(const EventRecord& event) {
  switch (event.code) {
    case JournalNews::kLosing:
      return "the journal cannot follow: ticks are missing from here on";
    case JournalNews::kResumed:
      return "the journal goes on, " + std::to_string(event.detail) + " ticks are missing";
    default:
      return "the journal ended: " +
             std::generic_category().message(static_cast<int>(event.detail));
  }
}

std::string parameters_text(const EventRecord& event) {
  switch (event.code) {
    case ParameterNews::kLoaded:
      return "stored parameters of " + std::to_string(event.detail) + " axes are in force";
    case ParameterNews::kPrevious:
      return "stored parameters: the file: " + ParameterNews::unpack(event.detail) +
             "; the set before it is in force";
    case ParameterNews::kDefaults:
      return "configured values are in force: " +
             std::string(event.axis == 0 ? "the file of stored parameters: " : "stored object ") +
             ParameterNews::unpack(event.detail);
    default:
      return "parameters not stored: " +
             std::generic_category().message(static_cast<int>(event.detail));
  }
}

std::string wire_text(const EventRecord& event) {
  switch (event.code) {
    case WireNews::kLost:
      return "the wire (network process) " + WireLoss::unpacked(event.detail).text() +
             "; the axes go on";
    case WireNews::kRuns:
      return "the wire runs again after " + std::to_string(event.detail) + " ms";
    default:
      return "the wire ends again and again; it is started in " + std::to_string(event.detail) +
             " ms";
  }
}

std::string text_of(const EventRecord& event) {
  switch (event.kind) {
    case msg::EVENT_STATE_CHANGED:
      return std::string(to_string(decode_power_state(static_cast<std::uint16_t>(event.code))));
    case msg::EVENT_FAULT:
      return "fault " + hex(event.code, 4);
    case msg::EVENT_FAULT_RESET:
      return "fault " + hex(event.code, 4) + " reset";
    case msg::EVENT_REFUSED:
      return refusal_text(event);
    case msg::EVENT_SET_POINT_IGNORED:
      return std::to_string(event.detail) + " set-points ignored";
    case msg::EVENT_CONTROL_CHANGED:
      return control_text(event);
    case msg::EVENT_MASTER_LOST:
      return "session " + hex(event.session, 16) + " fell silent, " + std::to_string(event.detail) +
             " axes lost their master";
    case msg::EVENT_TICK_OVERRUN:
      return "tick ended " + std::to_string(event.detail) + " us too late";
    case msg::EVENT_TICK_JUMPED:
      return "tick number jumped by " + std::to_string(event.detail);
    case msg::EVENT_QUEUE_OVERFLOW:
      return std::to_string(event.detail) + " messages lost: a queue was full";
    case msg::EVENT_SNAPSHOT:
      return snapshot_text(event);
    case msg::EVENT_JOURNAL:
      return journal_text(event);
    case msg::EVENT_PARAMETERS:
      return parameters_text(event);
    case msg::EVENT_BENCH_CONFLICT:
      return "another service has this bench number, incarnation " + std::to_string(event.detail);
    case msg::EVENT_CLOCK_CHANGED:
      return clock_text(event);
    case msg::EVENT_WALL_CLOCK:
      return wall_clock_text(event);
    case msg::EVENT_SHUTDOWN:
      return "the service shuts down: its axes brake, commands are refused";
    case msg::EVENT_WIRE:
      return wire_text(event);
    default:
      return "event " + std::to_string(event.kind);
  }
}

const char* name_of(std::uint32_t kind) {
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

}  // namespace

std::string log_line(std::uint32_t bench, const EventRecord& event, std::uint32_t suppressed) {
  std::string line = std::string("event=") + name_of(event.kind) +
                     " bench=" + std::to_string(bench) + " tick=" + std::to_string(event.tick);
  if (event.axis != 0) {
    line += " axis=" + std::to_string(event.axis);
  }
  if (event.session != 0) {
    line += " session=" + hex(event.session, 16);
  }
  if (event.code != 0) {
    line += " code=" + hex(event.code, 4);
  }
  return line + " suppressed=" + std::to_string(suppressed) + " text=\"" + words_of(event) + "\"";
}

std::string words_of(const EventRecord& event) {
  return (who(event) + text_of(event)).substr(0, kLongestText);
}

}  // namespace vdrive::service
