// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_report.hpp"

#include "vdrive/dictionary/object_table.hpp"

#include <cstdint>
#include <string>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using namespace literals;

/// @return the command needed first if the power state has refused a command, or nothing.
std::string next_step(const std::string& label, PowerState state) {
  const std::string first(command_before_motion(state));
  return first.empty() ? first : "; " + first + " it first: vdrive " + first + " " + label;
}

Record record_of(const CommandContext& context, const client::Axis& axis, const AxisReport& report,
                 const client::AxisSnapshot* status) {
  const std::string label = context.axes.label_of(axis.id());
  Record record{{"axis", to_string(axis.id()), report.result_record ? label + ":" : std::string()},
                {"command", report.command}};
  add_outcome(record, context.axes.named(report.outcome));
  if (report.result_record) {
    if (report.outcome)
      record.insert(record.end(), report.result_record->begin(), report.result_record->end());
  } else if (status != nullptr) {
    const std::int32_t position = status->status.load_position_actual_value;
    record.push_back({"tick", status->tick});
    record.push_back({"state", to_string(status->state())});
    record.push_back({"statusword", status->status.ds402_statusword,
                      report.has_arrived ? arrival_line(*status, label, axis.unit())
                                         : status_line(*status, label, axis.unit())});
    record.push_back({"position", position});
    add_in_unit(record, "load_position_actual_value"_object, axis.unit(), "position", position);
  }
  return record;
}

}  // namespace

std::string_view command_before_motion(PowerState state) noexcept {
  if (is_fault(state)) return "reset";
  return state == PowerState::operation_enabled ? "" : "enable";
}

Outcome report_axis(CommandContext& context, const client::Axis& axis, AxisReport report) {
  // The status of a lost bench is not read, because that would search for it until --timeout.
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
  print_answer(record_of(context, axis, report, status), report.outcome, context.output);
  return std::move(report.outcome);
}

void AxisFailures::take(client::Outcome reported, const CommandContext& context) {
  if (reported || !messages_.insert(reported.message()).second) return;
  if (first_) {
    first_ = std::move(reported);
  } else {
    context.output.terminal.print_error("vdrive: " + context.axes.named(reported).message());
  }
}

}  // namespace vdrive::tool
