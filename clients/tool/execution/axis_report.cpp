// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_report.hpp"

#include "vdrive/dictionary/object_table.hpp"

#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using namespace literals;

/// @return what to do first where the power state has refused a command, or nothing.
std::string next_step(const std::string& label, PowerState state) {
  const std::string first(command_before_motion(state));
  return first.empty() ? first : "; " + first + " it first: vdrive " + first + " " + label;
}

Json json_of_report(const CommandContext& context, const client::Axis& axis,
                    const AxisReport& report, const client::AxisSnapshot* status) {
  Json json{{"axis", to_string(axis.id())}, {"command", report.command}};
  add_outcome(json, context.axes.named(report.outcome));
  if (report.deed) {
    if (report.outcome) json.update(report.deed->facts);
  } else if (status != nullptr) {
    json["tick"] = status->tick;
    json["state"] = to_string(status->state());
    json["statusword"] = status->status.ds402_statusword;
    json["position"] = status->status.load_position_actual_value;
    add_in_unit(json, "load_position_actual_value"_object, axis.unit(), "position",
                status->status.load_position_actual_value);
  }
  return json;
}

}  // namespace

std::string_view command_before_motion(PowerState state) noexcept {
  if (is_fault(state)) return "reset";
  return state == PowerState::operation_enabled ? "" : "enable";
}

Outcome report_axis(CommandContext& context, const client::Axis& axis, AxisReport report) {
  // A bench that is lost shows nothing: the question would be a search of as long as --timeout.
  const bool shows_nothing = report.outcome.kind() == client::OutcomeKind::lost;
  if (context.output.is_quiet || shows_nothing) {
    return report_axis(context, axis, std::move(report), nullptr);
  }
  const auto status = axis.status();
  return report_axis(context, axis, std::move(report), status ? &*status : nullptr);
}

Outcome report_axis(CommandContext& context, const client::Axis& axis, AxisReport report,
                    const client::AxisSnapshot* status) {
  context.progress.end();
  if (context.output.is_quiet) return std::move(report.outcome);
  const std::string label = context.axes.label_of(axis.id());
  const bool is_refused_by_state =
      report.outcome.code() == wire_code(AbortCode::refused_in_present_device_state);
  const bool has_faulted = report.outcome.kind() == client::OutcomeKind::failed &&
                           status != nullptr && is_fault(status->state());
  if ((is_refused_by_state || has_faulted) && report.names_next_step && status != nullptr) {
    report.outcome =
        report.outcome.with_message(report.outcome.message() + next_step(label, status->state()));
  }
  const bool goes_on = report.outcome.kind() == client::OutcomeKind::timed_out &&
                       status != nullptr && status->status.velocity_demand_value != 0;
  if (goes_on) {
    report.outcome = report.outcome.with_message(report.outcome.message() +
                                                 "; to stop it: vdrive halt " + label);
  }
  if (context.output.is_json) {
    context.output.terminal.print(to_line(json_of_report(context, axis, report, status)));
  } else if (report.outcome && report.deed) {
    context.output.terminal.print(label + ": " + report.deed->text);
  } else if (report.outcome && status != nullptr) {
    context.output.terminal.print(report.has_arrived ? arrival_line(*status, label, axis.unit())
                                                     : status_line(*status, label, axis.unit()));
  }
  return std::move(report.outcome);
}

}  // namespace vdrive::tool
