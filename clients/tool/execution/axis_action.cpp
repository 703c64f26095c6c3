// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_action.hpp"

#include "base/usage_error.hpp"
#include "execution/axis_report.hpp"
#include "execution/axis_states.hpp"

#include <set>
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

std::vector<Outcome> command_all(std::vector<client::Axis>& axes, const AxisActionCommand& command,
                                 CommandContext& context) {
  const AxisAction& action = *command.action;
  if (action.together) {
    return context.session.command_each(axes, *action.together,
                                        context.call_options(command.until));
  }
  std::vector<Outcome> outcomes;
  outcomes.reserve(axes.size());
  for (client::Axis& axis : axes) outcomes.push_back(action.each(axis));
  return outcomes;
}

/// Keeps the first failure for the caller, who prints it; prints each further one once: the loss of
/// a bench is the same failure for all its axes.
class Failures {
 public:
  void take(Outcome reported, const CommandContext& context) {
    if (reported || !messages_.insert(reported.message()).second) return;
    if (first_) {
      first_ = std::move(reported);
    } else {
      context.output.terminal.complain("vdrive: " + context.axes.named(reported).message());
    }
  }

  [[nodiscard]] Outcome first() && { return std::move(first_); }

 private:
  std::set<std::string> messages_;
  Outcome first_;
};

}  // namespace

void AxisActionCommand::declare(Arguments& arguments) {
  arguments.axes(axes, "required unless --all is given");
  arguments.flag("--all", is_for_all, "Every axis of every bench");
  if (action->waits == Waits::on_request) {
    arguments.flag("--wait", is_wait_given, "Wait for standstill or target");
  } else if (action->waits == Waits::unless_declined) {
    arguments.no_wait(until);
  }
  arguments.take_over(take_over);
  arguments.then([this] {
    if (is_for_all && !axes.empty()) throw UsageError("--all cannot be combined with AXIS");
    if (!is_for_all && axes.empty()) {
      throw UsageError("AXIS is required, or --all for every axis of every bench");
    }
    if (is_for_all) axes = {"*"};
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
  const auto shown = context.output.is_quiet ? AxisStates() : states_of(context.session, *found);
  Failures failures;
  for (std::size_t i = 0; i < found->size(); ++i) {
    const client::Axis& axis = (*found)[i];
    const auto status = shown.states.find(axis.id());
    Outcome reported = report_axis(context, axis,
                                   {.command = action->name,
                                    .outcome = std::move(outcomes[i]),
                                    .names_next_step = action->names_next_step},
                                   status == shown.states.end() ? nullptr : &status->second);
    if (reported && action->gains_control) context.judge.note_control(axis.id());
    failures.take(std::move(reported), context);
  }
  return std::move(failures).first();
}

}  // namespace vdrive::tool
