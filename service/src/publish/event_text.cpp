// SPDX-License-Identifier: Apache-2.0
#include "publish/event_text.hpp"

#include "base/event_codes.hpp"
#include "configuration/wall_step_policy.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/event_kind.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <variant>

namespace vdrive::service {
namespace {

constexpr std::size_t kLongestText = 200;

/// @return the detail of the event; a default one if the event has no detail of this type.
template <typename Detail>
Detail detail_of(const EventRecord& event) {
  const auto* const detail = std::get_if<Detail>(&event.detail);
  return detail == nullptr ? Detail{} : *detail;
}

std::string counted(const EventRecord& event, std::string_view one, std::string_view many) {
  return vdrive::counted(detail_of<Count>(event).value, one, many);
}

std::string milliseconds_of(const EventRecord& event) {
  return std::to_string(
      std::chrono::floor<std::chrono::milliseconds>(detail_of<std::chrono::microseconds>(event))
          .count());
}

std::string who(const EventRecord& event) {
  return event.axis == 0 ? "" : "axis " + std::to_string(event.axis) + ": ";
}

std::string control_text(const EventRecord& event) {
  const std::string axes = event.axis != 0 ? "" : counted(event, "axis ", "axes ");
  if (event.code == 0) return axes + "released by session " + session_text(event.session);
  return axes + "controlled by session " + session_text(event.session) + " in epoch " +
         std::to_string(event.code);
}

std::string lost_text(const EventRecord& event) {
  const auto [count, silence_ms] = detail_of<LostAxes>(event);
  return "nothing was received from session " + session_text(event.session) + " for " +
         std::to_string(silence_ms) + " ms; " +
         vdrive::counted(count, "axis lost its", "axes lost their") + " master";
}

std::string refusal_text(const EventRecord& event) {
  const auto [number, late_by] = detail_of<RefusedMessage>(event);
  const std::string late = late_by == 0 ? "" : ", late by " + std::to_string(late_by) + " ticks";
  return "refused: " + wire::describe_reason(event.code) + late + " (session " +
         session_text(event.session) + ", number " + std::to_string(number) + ")";
}

std::string clock_text(const EventRecord& event) {
  const std::string session = "session " + session_text(event.session);
  switch (event.code) {
    case wire::number(msg::RequestKind::set_rate): {
      const double rate = detail_of<NewRate>(event).value;
      return rate == 0.0 ? "clock paused by " + session
                         : "rate set to " + to_text(rate) + " by " + session;
    }
    case wire::number(msg::RequestKind::join_clock):
      return session + " joined the clock";
    default:
      break;
  }
  switch (detail_of<StepperRemoval>(event)) {
    case StepperRemoval::silent:
      return session + " was removed from the clock: it sent nothing while others waited for it";
    case StepperRemoval::gone:
      return session + " was removed from the clock: its program left the network";
    default:
      return session + " left the clock";
  }
}

std::string wall_clock_text(const EventRecord& event) {
  const double offset =
      std::chrono::duration<double>(detail_of<std::chrono::microseconds>(event)).count();
  const std::string place = "the wall clock was changed: it is " + to_text(std::abs(offset)) +
                            (offset < 0.0 ? " s behind" : " s ahead of");
  if (event.code == WallClockCode::kJumped) return place + " drive time; the tick number jumps";
  const auto seconds = static_cast<std::uint64_t>(std::abs(offset) / kMaxSteering);
  return place + " drive time; drive time is adjusted by " +
         std::to_string(std::lround(kMaxSteering * 1e6)) + " ppm for about " +
         std::to_string(seconds) + " s";
}

std::string stop_text(const EventRecord& event) {
  const std::string how = (event.code & Controlword::kHalt) != 0 ? "halted" : "quick stop";
  const std::string by =
      event.session == 0 ? "a client without a session" : "session " + session_text(event.session);
  return how + " by " + by + "; session " + session_text(detail_of<Label>(event).value) +
         " keeps control";
}

std::string snapshot_text(const EventRecord& event) {
  const char* const what = event.code == SnapshotCode::kTaken      ? " taken"
                           : event.code == SnapshotCode::kRestored ? " restored"
                                                                   : " dropped";
  return "snapshot " + std::to_string(detail_of<Label>(event).value) + what;
}

std::string journal_text(const EventRecord& event) {
  switch (event.code) {
    case JournalCode::kLosing:
      return "the journal cannot keep up: it misses ticks from here on";
    case JournalCode::kResumed:
      return "the journal continues; " + counted(event, "tick is missing", "ticks are missing");
    default:
      return "the journal cannot be written: " + detail_of<SystemError>(event).text() +
             "; recording has stopped";
  }
}

std::string parameters_text(const EventRecord& event) {
  switch (event.code) {
    case ParameterCode::kLoaded:
      return "stored parameters loaded for " + counted(event, "axis", "axes");
    case ParameterCode::kPrevious:
      return "the parameter file cannot be used: " + detail_of<StoredProblem>(event).text() +
             "; the previous set is used";
    case ParameterCode::kDefaults:
      return "configured values are used instead of stored ones: " +
             std::string(event.axis == 0 ? "parameter file: " : "stored object ") +
             detail_of<StoredProblem>(event).text();
    default:
      return "parameters not stored: " + detail_of<SystemError>(event).text();
  }
}

std::string wire_text(const EventRecord& event) {
  switch (event.code) {
    case WireCode::kLost:
      return "the wire (network process) failed: " + detail_of<WireLoss>(event).text() +
             "; the axes continue";
    case WireCode::kRuns:
      return "the wire runs again after " + milliseconds_of(event) + " ms";
    default:
      return "the wire fails repeatedly; the service starts it again in " + milliseconds_of(event) +
             " ms";
  }
}

std::string state_text(const EventRecord& event) {
  return std::string(to_string(decode_power_state(static_cast<std::uint16_t>(event.code))));
}

std::string fault_text(const EventRecord& event) {
  return "fault " + hex(event.code, 4);
}

std::string reset_text(const EventRecord& event) {
  return fault_text(event) + " reset";
}

std::string ignored_text(const EventRecord& event) {
  return counted(event, "set-point", "set-points") + " ignored";
}

std::string overrun_text(const EventRecord& event) {
  const auto [count, worst, span] = detail_of<Overruns>(event);
  const std::string late = std::to_string(worst.count()) + " us";
  if (count == 1) return "tick ended " + late + " late";
  const std::chrono::duration<double> seconds = span;
  return std::to_string(count) + " ticks in " + to_text(seconds.count()) +
         " s ended late, by up to " + late;
}

std::string jump_text(const EventRecord& event) {
  return "tick number jumped by " + counted(event, "tick", "ticks");
}

std::string overflow_text(const EventRecord& event) {
  return counted(event, "message", "messages") + " lost because a queue was full";
}

std::string conflict_text(const EventRecord& event) {
  return "another service has the same bench number (incarnation " +
         std::to_string(detail_of<Label>(event).value) + ")";
}

std::string shutdown_text(const EventRecord& /*event*/) {
  return "the service is shutting down: its axes brake, commands are refused";
}

/// The text and the log level of a kind of event.
struct EventRow {
  EventKind kind{};
  spdlog::level::level_enum level = spdlog::level::debug;
  std::string (*text)(const EventRecord& event) = nullptr;  ///< without the axis
};

constexpr auto kDebug = spdlog::level::debug;
constexpr auto kInfo = spdlog::level::info;
constexpr auto kWarn = spdlog::level::warn;

/// In the order of their numbers. A kind without a row is logged by its name, at a level that
/// follows from its severity.
constexpr auto kEventRows = std::to_array<EventRow>({
    {EventKind::state_changed, kDebug, state_text},
    {EventKind::fault, kInfo, fault_text},
    {EventKind::fault_reset, kInfo, reset_text},
    {EventKind::refused, kInfo, refusal_text},
    {EventKind::set_point_ignored, kDebug, ignored_text},
    {EventKind::control_changed, kDebug, control_text},
    {EventKind::master_lost, kWarn, lost_text},
    {EventKind::tick_overrun, kDebug, overrun_text},
    {EventKind::tick_jumped, kWarn, jump_text},
    {EventKind::queue_overflow, kWarn, overflow_text},
    {EventKind::bench_conflict, spdlog::level::err, conflict_text},
    {EventKind::clock_changed, kInfo, clock_text},
    {EventKind::snapshot, kInfo, snapshot_text},
    {EventKind::journal, kWarn, journal_text},
    {EventKind::shutdown, kInfo, shutdown_text},
    {EventKind::parameters, kWarn, parameters_text},
    {EventKind::wall_clock, kWarn, wall_clock_text},
    {EventKind::wire, kWarn, wire_text},
    {EventKind::stopped, kInfo, stop_text},
});

EventKind kind_of(const EventRecord& event) {
  return static_cast<EventKind>(event.kind);
}

const EventRow* event_row_of(const EventRecord& event) {
  const auto* const row = std::ranges::find(kEventRows, kind_of(event), &EventRow::kind);
  return row == kEventRows.end() ? nullptr : row;
}

}  // namespace

std::string log_line(std::uint32_t bench, const EventRecord& event, std::uint64_t suppressed) {
  std::string line = "event=" + std::string(to_string(kind_of(event))) +
                     " bench=" + std::to_string(bench) + " tick=" + std::to_string(event.tick);
  if (event.axis != 0) line += " axis=" + std::to_string(event.axis);
  if (event.session != 0) line += " session=" + session_text(event.session);
  if (event.code != 0) line += " code=" + hex(event.code, 4);
  return line + " suppressed=" + std::to_string(suppressed) + " text=\"" + words_of(event) + "\"";
}

std::string words_of(const EventRecord& event) {
  const EventRow* const row = event_row_of(event);
  const std::string text = row != nullptr ? row->text(event)
                           : vdrive::row_of(kind_of(event)) != nullptr
                               ? std::string(to_string(kind_of(event)))
                               : "event " + std::to_string(wire::number(event.kind));
  return (who(event) + text).substr(0, kLongestText);
}

spdlog::level::level_enum level_of(const EventRecord& event) {
  if (event.kind == msg::EventKind::parameters && event.code == ParameterCode::kLoaded)
    return kInfo;
  const EventRow* const row = event_row_of(event);
  if (row != nullptr) return row->level;
  return severity_of(kind_of(event)) == EventSeverity::info ? kDebug : kWarn;
}

}  // namespace vdrive::service
