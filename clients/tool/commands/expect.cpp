// SPDX-License-Identifier: Apache-2.0
#include "commands/expect.hpp"

#include "base/usage_error.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"

#include <limits>
#include <vector>

namespace vdrive::tool {
namespace {

/// The texts of the options: what they mean depends on OBJECT.
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

/// Behind AXIS and OBJECT. Behind a comparison the value has no completion.
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
  tell_progress_of(expected, *found, context);
  client::Outcome outcome = context.judge.judge(*found, expected);
  context.progress.end();
  const Output& output = context.output;
  if (output.is_quiet) return outcome;
  if (output.is_json) {
    Json json = object_json(found->id(), expected.object);
    add_outcome(json, context.axes.named(outcome));
    json["comparison"] = to_string(expected.comparison);
    json["expected"] = expected.value;
    add_in_unit(json, expected.object.row(), expected.unit, "expected", expected.value);
    if (context.judge.found()) json.update(*context.judge.found());
    output.terminal.print(to_line(json));
  } else if (outcome) {
    output.terminal.print(context.axes.label_of(found->id()) + " " + expected.object.text + ": " +
                          expected_text(expected) + ", as expected");
  }
  return outcome;
}

extern const CommandRow kExpect =
    row_of<ExpectCommand>({.name = "expect",
                           .group = CommandGroup::scenarios,
                           .summary = "Compare an object; exit code 1 when it is another value",
                           .example = "expect 1.1 position 1000 --tolerance 1\n"
                                      "  vdrive expect 1.1 torque '<' 500 --throughout 2s"});

}  // namespace vdrive::tool
