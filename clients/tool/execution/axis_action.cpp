// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

#include "execution/axis_report.hpp"
#include "execution/axis_states.hpp"
#include "vdrive/wording.hpp"

#include <atomic>
#include <memory>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;

Outcome take_over_all(std::vector<client::Axis>& axes) {
  for (client::Axis& axis : axes) {
    if (Outcome taken = axis.take_over(); !taken) return taken;
  }
  return {};
}

void tell_progress(const std::vector<client::Axis>& axes, const AxisAction& action,
                   CommandContext& context) {
  const std::string name(action.name);
  if (axes.size() == 1) {
    context.progress.axis(axes.front(), context.axes.label_of(axes.front().id()), name);
  } else {
    context.progress.axes(name, axes, action.is_done);
  }
}

std::vector<Outcome> command_all(std::vector<client::Axis>& axes, const AxisActionCommand& command,
                                 CommandContext& context) {
  const AxisAction& action = *command.action;
  if (action.together) {
    tell_progress(axes, action, context);
    client::CallOptions options = context.call_options(command.until);
    options.keep_target = command.keep_target;
    return context.session.command_each(axes, *action.together, options);
  }
  std::vector<Outcome> outcomes;
  outcomes.reserve(axes.size());
  const auto done = std::make_shared<std::atomic<std::size_t>>(0);
  context.progress.tell([done, name = action.name, all = axes.size()] {
    return count_text(name, *done, all);
  });
  for (client::Axis& axis : axes) {
    outcomes.push_back(action.each(axis));
    ++*done;
  }
  return outcomes;
}

/// @return the axes whose bench is not lost: a lost one would be searched for until --timeout.
std::vector<client::Axis> present(const std::vector<client::Axis>& axes,
                                  const std::vector<Outcome>& outcomes) {
  std::vector<client::Axis> present;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (outcomes[i].kind() != client::OutcomeKind::lost) present.push_back(axes[i]);
  }
  return present;
}

}  // namespace

void AxisActionCommand::declare(Arguments& arguments) {
  arguments.axes_or_all(axes);
  if (action->waits == Waits::on_request) {
    arguments.flag("--wait", is_wait_given, "Wait for standstill or target");
  } else if (action->waits == Waits::unless_declined) {
    arguments.no_wait(until);
  }
  if (action->together == client::EachCommand::enable) {
    arguments.flag("--keep-target", keep_target,
                   "Keep 60FFh, 6042h and 6071h unchanged: the axis may start to move immediately");
  }
  arguments.take_over(take_over);
  arguments.then([this] {
    const bool returns_early = action->waits == Waits::on_request && !is_wait_given;
    if (returns_early) until = client::Until::in_force;
  });
}

Outcome AxisActionCommand::run(CommandContext& context) const {
  auto found = context.axes.axes(axes);
  if (!found) return found.outcome();
  if (take_over) {
    if (Outcome taken = take_over_all(*found); !taken) return taken;
  }
  std::vector<Outcome> outcomes = command_all(*found, *this, context);
  context.progress.time("status of " + counted(found->size(), "axis", "axes"));
  const auto shown = context.output.is_quiet
                         ? AxisStates()
                         : states_of(context.session, present(*found, outcomes));
  context.progress.end();
  AxisFailures failures;
  for (std::size_t i = 0; i < found->size(); ++i) {
    const client::Axis& axis = (*found)[i];
    const auto status = shown.states.find(axis.id());
    AxisReport report{.command = action->name,
                      .outcome = std::move(outcomes[i]),
                      .names_next_step = action->names_next_step};
    if (action->result_record != nullptr) report.result_record = action->result_record(axis);
    Outcome reported = report_axis(context, axis, std::move(report),
                                   status == shown.states.end() ? nullptr : &status->second);
    if (reported && action->gains_control) context.judge.note_control(axis.id());
    failures.take(std::move(reported), context);
  }
  return std::move(failures).first();
}

}  // namespace vdrive::tool
