// SPDX-License-Identifier: Apache-2.0
#include "commands/wait.hpp"

#include "base/usage_error.hpp"
#include "execution/axis_report.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "values/condition.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <span>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

/// @throws UsageError for 1.1, which is an axis without a condition more often than 1.1 s.
Duration parse_time(const std::string& text) {
  if (!client::parse_axis_id(text)) return parse_duration(text);
  throw UsageError(in_quotes(text) + " is an axis: write what to wait for, such as 'wait " + text +
                   " target_reached', or the unit of a time, such as 'wait " + text + "s'");
}

WaitCommand parse_wait(const std::vector<std::string>& what) {
  WaitCommand wait;
  if (what.size() == 1) {
    wait.duration = parse_time(what.front());
    return wait;
  }
  wait.axis = what[0];
  if (what.size() > 2) {
    wait.expectation = parse_expectation(what[1], std::span(what).subspan(2));
    return wait;
  }
  wait.condition = what[1];
  const std::vector<std::string>& names = condition_names();
  if (std::ranges::find(names, wait.condition) == names.end()) {
    throw UsageError(in_quotes(wait.condition) + " is not a condition" +
                     condition_suggestion(wait.condition) +
                     "; 'vdrive wait --help' lists all conditions");
  }
  return wait;
}

std::string help_of_what() {
  std::string help =
      "AXIS CONDITION, AXIS OBJECT [COMPARISON] VALUE, or DURATION of drive time. CONDITION is a "
      "state or a bit of the statusword:";
  std::string_view separator = " ";
  for (const std::string& name : condition_names()) {
    help.append(separator).append(name);
    separator = ", ";
  }
  return help;
}

std::vector<std::string> complete_wait(std::span<const std::string> before,
                                       const BenchNames& names) {
  if (before.empty()) return names.axes();
  if (before.size() > 1) return {};
  std::vector<std::string> words = condition_names();
  std::ranges::move(complete_object(before, names), std::back_inserter(words));
  return words;
}

/// Of the benches whose axes the commands before have named, or of the only one.
Outcome wait_for_time(Duration duration, CommandContext& context) {
  if (context.axes.benches().empty()) {
    const auto only = find_bench(context.session, std::nullopt,
                                 "wait applies to the benches whose axes the file names");
    if (!only) return only.outcome();
    context.axes.add_bench(only->number);
  }
  const std::string seconds = to_text(std::chrono::duration<double>(duration).count());
  for (const std::uint32_t bench : context.axes.benches()) {
    context.progress.time("bench " + std::to_string(bench) + ": waiting for " + seconds +
                          " s of drive time");
    const auto reached = context.session.wait(bench, duration);
    context.progress.end();
    if (Outcome reported = report_clock(context.output, {{"bench", bench}, {"command", "wait"}},
                                        "bench " + std::to_string(bench), reached);
        !reported) {
      return reported;
    }
  }
  return {};
}

Outcome await_value(client::Axis& axis, const Expectation& awaited, Duration limit,
                    CommandContext& context) {
  Expectation expectation = context.axes.in_user_units(axis, awaited);
  expectation.within = limit;
  tell_progress_of(expectation, axis, context);
  Outcome outcome = context.judge.judge(axis, expectation);
  const auto& found = context.judge.found();
  const bool is_late = found && !found->contains("error_code");
  return is_late ? Outcome::timed_out(outcome.message()) : outcome;
}

}  // namespace

void WaitCommand::declare(Arguments& arguments) {
  arguments.positionals("WHAT", *this, help_of_what(), parse_wait)
      .required()
      .completed_by(complete_wait);
}

void WaitCommand::check_objects() const {
  if (expectation) check_expectation(*expectation);
}

void WaitCommand::check_units(const CommandContext& context, const client::Axis& observed) const {
  if (expectation) static_cast<void>(context.axes.in_user_units(observed, *expectation));
}

Outcome WaitCommand::run(CommandContext& context) const {
  if (duration) return wait_for_time(*duration, context);
  constexpr std::chrono::seconds kLimit{60};  // of drive time, as for a motion
  auto found = context.axes.axis(axis);
  if (!found) return found.outcome();
  const Duration limit = context.timeout.value_or(kLimit);
  if (!expectation) {
    context.progress.axis(*found, context.axes.label_of(found->id()), "waiting for " + condition);
  }
  Outcome outcome = expectation ? await_value(*found, *expectation, limit, context)
                                : context.judge.await(*found, condition, limit);
  return report_axis(context, *found, {.command = "wait", .outcome = std::move(outcome)});
}

extern const CommandRow kWait = row_of<WaitCommand>(
    {.name = "wait",
     .group = CommandGroup::scenarios,
     .summary = "Wait for a state or a value of an axis; exit code 4 after --timeout",
     .example = "wait 1.1 target_reached --timeout 5s\n"
                "  vdrive wait 1.1 position '>' 1000\n"
                "  vdrive wait 500ms"});

}  // namespace vdrive::tool
