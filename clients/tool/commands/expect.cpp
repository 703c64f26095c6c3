// SPDX-License-Identifier: Apache-2.0
#include "commands/expect.hpp"

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
#include <limits>
#include <span>
#include <vector>

namespace vdrive::tool {
namespace {

/// The texts of the options, whose meaning depends on OBJECT.
struct BoundTexts {
  const std::string& mask;
  const std::string& tolerance;
};

void read_bounds(Expectation& expectation, const BoundTexts& texts) {
  const bool is_ordered = expectation.comparison != Comparison::equal &&
                          expectation.comparison != Comparison::not_equal;
  if (is_ordered && (!texts.mask.empty() || !texts.tolerance.empty())) {
    throw UsageError("--mask and --tolerance go with == and !=, not with " +
                     std::string(to_string(expectation.comparison)));
  }
  if (!texts.mask.empty()) {
    expectation.mask = static_cast<std::uint64_t>(parse_value(texts.mask, expectation.object));
  }
  if (texts.tolerance.empty()) return;
  constexpr std::uint64_t kHighest = std::numeric_limits<std::uint32_t>::max();
  expectation.quantity_of_tolerance = parse_quantity(texts.tolerance, expectation.object);
  if (expectation.quantity_of_tolerance) {
    expectation.quantity_of_tolerance->type = DataType::unsigned32;
  }
  expectation.tolerance =
      expectation.quantity_of_tolerance ? 0 : parse_number(texts.tolerance, "tolerance", kHighest);
}

/// Completes the word after AXIS and OBJECT. There is no completion for the value after a
/// comparison.
std::vector<std::string> complete_comparison(std::span<const std::string> before,
                                             const BenchNames& /*names*/) {
  if (before.size() != 2) return {};
  return {"==", "!=", "<", "<=", ">", ">="};
}

}  // namespace

void ExpectCommand::declare(Arguments& arguments) {
  std::string& object = arguments.text();
  std::string& mask = arguments.text();
  std::string& tolerance = arguments.text();
  arguments.axis(axis);
  arguments.positional("OBJECT", object, "0x6064, 0x607D:1 or a variable_name")
      .required()
      .completed_by(complete_object);
  arguments
      .positionals("VALUE", expectation,
                   "[COMPARISON] VALUE: the comparison is ==, !=, <, <=, > or >=; default: ==",
                   [&object](const std::vector<std::string>& values) {
                     return parse_expectation(object, values);
                   })
      .required()
      .completed_by(complete_comparison);
  const Argument masked = arguments.option("--mask", "M", mask, "Compare these bits only");
  arguments.option("--tolerance", "T", tolerance, "A difference of at most T is equal")
      .excludes(masked);
  arguments.then([this, &mask, &tolerance] {
    read_bounds(expectation, {mask, tolerance});
  });
  const Argument soon = arguments.option("--within", "D", expectation.within,
                                         "Wait at most this drive time for it", parse_duration);
  arguments
      .option("--throughout", "D", expectation.throughout, "Check every tick of this drive time",
              parse_duration)
      .excludes(soon);
}

void ExpectCommand::check_objects() const {
  check_expectation(expectation);
}

void ExpectCommand::check_units(const CommandContext& context, const client::Axis& observed) const {
  static_cast<void>(context.axes.in_user_units(observed, expectation));
}

client::Outcome ExpectCommand::run(CommandContext& context) const {
  auto found = context.axes.axis(axis);
  if (!found) return found.outcome();
  const Expectation expected = context.axes.in_user_units(*found, expectation);
  show_progress_of(expected, *found, context);
  client::Outcome outcome = context.judge.judge(*found, expected);
  context.progress.end();
  Record record = object_fields(found->id(), expected.object);
  add_outcome(record, context.axes.named(outcome));
  record.push_back({"comparison", to_string(expected.comparison)});
  record.push_back({"expected", expected.value,
                    context.axes.label_of(found->id()) + " " + expected.object.text + ": " +
                        expected_text(expected) + ", as expected"});
  add_in_unit(record, expected.object.row(), expected.unit, "expected", expected.value);
  if (context.judge.found()) add_members(record, *context.judge.found());
  print_answer(record, outcome, context.output);
  return outcome;
}

extern const CommandRow kExpect =
    row_of<ExpectCommand>({.name = "expect",
                           .group = CommandGroup::scenarios,
                           .summary = "Compare an object with a value; exit code 1 if they differ",
                           .example = "expect 1.1 position 1000 --tolerance 1\n"
                                      "  vdrive expect 1.1 torque '<' 500 --throughout 2s"});

namespace {

using client::Outcome;

/// @throws UsageError for a text such as 1.1: the user has probably named an axis and forgotten the
///         condition, rather than meant 1.1 s.
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

/// Waits on the benches whose axes earlier commands have named, otherwise on the only bench.
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
    if (Outcome reported =
            report_tick({{"bench", bench, "bench " + std::to_string(bench)}, {"command", "wait"}},
                        reached, context.output);
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
  show_progress_of(expectation, axis, context);
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
  constexpr std::chrono::seconds kLimit{60};  // drive time, as for a motion
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
