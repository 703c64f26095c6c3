// SPDX-License-Identifier: Apache-2.0
#include "execution/failure_report.hpp"

#include "execution/axis_report.hpp"
#include "execution/axis_states.hpp"
#include "output/report.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/quantity.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

// If a command to every axis of a large bench fails, a line for each would not help.
constexpr std::size_t kMostAxes = 4;

/// @return one line, such as "axis 1.1 at tick 42: 0x637 Operation enabled: target reached; ...".
std::string axis_text(const client::Axis& axis, const client::AxisSnapshot& shown,
                      const std::string& label) {
  const AxisStatus& status = shown.status;
  return "axis " + label + " at tick " + std::to_string(shown.tick) + ": " +
         hex(status.ds402_statusword, 3) + " " + state_text(shown) + "; position " +
         quantity_text(status.load_position_actual_value, Dimension::position, axis.unit()) +
         ", velocity " +
         quantity_text(status.load_velocity_actual_value, Dimension::velocity, axis.unit()) +
         ", torque " + per_mille_text(status.torque_actual_value) + ", mode " +
         std::to_string(status.op_mode_actual) + " " + std::string(to_string(shown.mode()));
}

/// The facts for choosing the next step.
struct FailedCommand {
  const Outcome& outcome;
  const std::optional<Json>& found;  ///< by the judge of expectations
  const client::AxisSnapshot* axis;  ///< the first one, nullptr if unknown
  std::string label;                 ///< the axis as the user has typed it
  bool is_private;                   ///< its bench, with the events, ends with this program
};

/// @return whether the value differed from the expected one; false if a wait reached its limit.
bool is_other_value(const Outcome& outcome, const std::optional<Json>& found) {
  return found && found->contains("expected") && outcome.kind() != OutcomeKind::timed_out;
}

std::string advice_of_refusal(const FailedCommand& failed) {
  if (failed.outcome.code() == wire_code(AbortCode::refused_local_control)) {
    return "another session controls the axis: end it, or add --take-over to this line";
  }
  return "change the command, or write 'refused " + hex(failed.outcome.code(), 8) +
         "' in front of it if the refusal is intended";
}

bool is_moving(const client::AxisSnapshot* axis) {
  return axis != nullptr && axis->status.velocity_demand_value != 0;
}

std::string advice_of_expectation(const FailedCommand& failed) {
  if ((*failed.found)["expected"].is_string()) {
    return "remove 'refused' from this line, or correct its code";
  }
  if (is_moving(failed.axis)) {
    return "the axis is moving: write 'wait " + failed.label +
           " target_reached' above this line, or add --within to it";
  }
  return "add --within if the value is reached later, or --tolerance if it is only approximate; "
         "otherwise check the commands above this line";
}

/// @param first the command that ends the fault
std::string advice_of_fault(const FailedCommand& failed, std::string_view first) {
  const std::string cause =
      failed.is_private ? "the line of the axis shows the cause of the fault"
                        : "'vdrive events " + failed.label + "' shows the cause of the fault";
  return cause + "; '" + std::string(first) + " " + failed.label + "' above this line ends it";
}

std::string advice_of_time_out(const FailedCommand& failed) {
  return is_moving(failed.axis) ? "the axis is moving: allow more time with --timeout"
                                : "the axis is at standstill: its statusword shows what it waits "
                                  "for; or allow more time with --timeout";
}

std::string advice_of_private(const Outcome& outcome) {
  switch (outcome.kind()) {
    case OutcomeKind::lost:
      return "the bench has ended: 'vdrive run' without --private runs the file on a bench that is "
             "already running";
    case OutcomeKind::not_found:
      return "the bench has the axes of --config, or those of the demo bench without it";
    default:
      return "'vdrive run --private --live' shows the axes while the file runs";
  }
}

std::string advice_of_shared(const Outcome& outcome) {
  switch (outcome.kind()) {
    case OutcomeKind::lost:
      return "'vdrive events' shows who took control or which bench ended; 'vdrive run --private' "
             "runs the file on a bench that no other program can reach";
    case OutcomeKind::not_found:
      return "'vdrive list' shows the available benches and axes";
    default:
      return "'vdrive events' shows what led to it; 'vdrive run --live' shows the axes while the "
             "file runs";
  }
}

std::string advice_of(const FailedCommand& failed) {
  const PowerState state =
      failed.axis == nullptr ? PowerState::operation_enabled : failed.axis->state();
  const bool is_refused_by_state =
      failed.outcome.code() == wire_code(AbortCode::refused_in_present_device_state);
  const std::string_view first = command_before_motion(state);
  if (is_fault(state)) return advice_of_fault(failed, first);
  if (is_refused_by_state && !first.empty()) {
    return "write '" + std::string(first) + " " + failed.label + "' above this line";
  }
  if (is_other_value(failed.outcome, failed.found)) return advice_of_expectation(failed);
  switch (failed.outcome.kind()) {
    case OutcomeKind::refused:
      return advice_of_refusal(failed);
    case OutcomeKind::timed_out:
      return advice_of_time_out(failed);
    default:
      return failed.is_private ? advice_of_private(failed.outcome)
                               : advice_of_shared(failed.outcome);
  }
}

/// @return the axes to read.
std::vector<client::Axis> axes_of_failure(const Command& command, CommandContext& context) {
  if (command.axes.empty()) return context.axes.known();
  auto named = context.axes.axes(command.axes);
  return named ? std::move(*named) : std::vector<client::Axis>();
}

}  // namespace

FailureReport report_failure(const Command& command, const Outcome& outcome,
                             CommandContext& context) {
  FailureReport report;
  if (context.session.is_interrupted()) return report;
  // A lost bench cannot be asked.
  std::vector<client::Axis> axes = outcome.kind() == OutcomeKind::lost
                                       ? std::vector<client::Axis>()
                                       : axes_of_failure(command, context);
  const std::size_t left_out = axes.size() - std::min(axes.size(), kMostAxes);
  axes.erase(axes.end() - static_cast<std::ptrdiff_t>(left_out), axes.end());
  const AxisStates shown = states_of(context.session, axes);
  FailedCommand failed{.outcome = outcome,
                       .found = context.judge.found(),
                       .axis = nullptr,
                       .label = {},
                       .is_private = context.is_private};
  for (const client::Axis& axis : axes) {
    const auto state = shown.states.find(axis.id());
    if (state == shown.states.end()) continue;
    const std::string label = context.axes.label_of(axis.id());
    report.axes.push_back(axis_text(axis, state->second, label));
    if (failed.axis != nullptr) continue;
    failed.axis = &state->second;
    failed.label = label;
    report.tick = state->second.tick;
  }
  if (left_out != 0)
    report.axes.push_back("and " + counted(left_out, "further axis", "further axes"));
  if (failed.found && failed.found->contains("tick")) {
    report.tick = (*failed.found)["tick"].get<std::uint64_t>();
  }
  report.advice = advice_of(failed);
  return report;
}

std::string failure_type(const Outcome& outcome, const std::optional<Json>& found) {
  return is_other_value(outcome, found) ? "expectation" : std::string(to_string(outcome.kind()));
}

}  // namespace vdrive::tool
