// SPDX-License-Identifier: Apache-2.0
// The commands that change the power state of axes, stop them and let them continue.
#include "commands/power.hpp"

#include "execution/axis_action.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/wording.hpp"

namespace vdrive::tool {
namespace {

using client::EachCommand;

bool is_enabled(const client::AxisSnapshot& axis) {
  return axis.state() == PowerState::operation_enabled;
}

bool is_disabled(const client::AxisSnapshot& axis) {
  return axis.state() != PowerState::operation_enabled;
}

bool has_no_fault(const client::AxisSnapshot& axis) {
  return !is_fault(axis.state());
}

bool has_come_to_rest(const client::AxisSnapshot& axis) {
  return axis.status.velocity_demand_value == 0;
}

constexpr AxisAction kEnableAction{.name = "enable",
                                   .together = EachCommand::enable,
                                   .gains_control = true,
                                   .is_done = is_enabled};
constexpr AxisAction kDisableAction{
    .name = "disable", .together = EachCommand::disable, .is_done = is_disabled};
constexpr AxisAction kResetAction{.name = "reset",
                                  .together = EachCommand::reset_fault,
                                  .names_next_step = false,
                                  .is_done = has_no_fault};
constexpr AxisAction kQuickStopAction{.name = "quick-stop",
                                      .waits = Waits::unless_declined,
                                      .together = EachCommand::quick_stop,
                                      .is_done = has_come_to_rest};
constexpr AxisAction kPowerCycleAction{.name = "power-cycle", .together = EachCommand::power_cycle};
constexpr AxisAction kHaltAction{.name = "halt",
                                 .waits = Waits::on_request,
                                 .together = EachCommand::halt,
                                 .is_done = has_come_to_rest};
constexpr AxisAction kResumeAction{.name = "resume",
                                   .waits = Waits::on_request,
                                   .together = EachCommand::resume,
                                   .is_done = has_come_to_rest};

}  // namespace

extern const CommandRow kEnable = action_row<kEnableAction>(
    CommandGroup::power, "Go through the power states to Operation enabled", "enable 1.1");
extern const CommandRow kDisable = action_row<kDisableAction>(
    CommandGroup::power, "Shut down (0x06): to Ready to switch on", "disable 1.1");
extern const CommandRow kReset = action_row<kResetAction>(
    CommandGroup::power, "Reset a fault (rising edge of bit 7)", "reset 1.1");
extern const CommandRow kQuickStop = action_row<kQuickStopAction>(
    CommandGroup::power, "Quick stop (0x02), wait for standstill", "quick-stop 1.1");
extern const CommandRow kPowerCycle = action_row<kPowerCycleAction>(
    CommandGroup::power, "Switch the axis off and on again", "power-cycle 1.1");
extern const CommandRow kHalt = action_row<kHaltAction>(
    CommandGroup::motion, "Brake to standstill, keep the set-point (0x010F)", "halt 1.1");
extern const CommandRow kResume = action_row<kResumeAction>(
    CommandGroup::motion, "End a halt and continue the set-point (0x0F)", "resume 1.1");

void StopCommand::declare(Arguments& arguments) {
  arguments.optional_positional("BENCH", bench, "Default: the only bench", parse_bench)
      .completed_by(complete_bench);
  arguments.no_wait(until);
}

client::Outcome StopCommand::run(CommandContext& context) const {
  const auto found = context.session.find_bench(bench);
  if (!found) return found.outcome();
  client::Outcome outcome = context.session.quick_stop(found->number, context.call_options(until));
  Record record{
      {"bench", found->number, "bench " + std::to_string(found->number) + ":"},
      {"command", "stop"},
      {"axes", found->axes.size(), "quick stop of " + counted(found->axes.size(), "axis", "axes")}};
  add_outcome(record, outcome);
  print_answer(record, outcome, context.output);
  return outcome;
}

extern const CommandRow kStop =
    row_of<StopCommand>({.name = "stop",
                         .group = CommandGroup::power,
                         .summary = "Quick stop of every axis of a bench, also of other sessions",
                         .example = "stop 1"});

}  // namespace vdrive::tool
