// SPDX-License-Identifier: Apache-2.0
#include "execution/command_context.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

#include <string>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

/// `refused`: passes if the command is refused with this code.
Outcome judge_refusal(const Outcome& outcome, std::uint32_t code, CommandContext& context) {
  if (outcome.kind() == OutcomeKind::refused && outcome.code() == code) return {};
  const std::string actual = outcome ? "accepted" : outcome.message();
  context.judge.set_found({{"expected", hex(code, 8)}, {"actual", actual}});
  return Outcome::failed("expected the refusal " + hex(code, 8) + ", actual: " + actual);
}

}  // namespace

void BenchChanges::note_write(const client::Axis& axis, ObjectAddress object, std::int64_t value) {
  if (!has_role(object, Role::test_input)) return;
  disturbed_.erase(std::pair(axis.id(), object));
  if (value != 0) disturbed_.emplace(std::pair(axis.id(), object), axis);
}

std::vector<std::string> BenchChanges::put_back(const AxisFinder& axes) {
  std::vector<std::string> done;
  for (const auto& [bench, rate] : std::exchange(rates_before_, {})) {
    if (!session_.set_rate(bench, rate)) continue;
    done.push_back("rate of bench " + std::to_string(bench) + " is " + to_text(rate));
  }
  for (auto& [input, axis] : std::exchange(disturbed_, {})) {
    const auto row = find_object(input.second);
    if (!row || !axis.write(input.second, 0)) continue;
    done.push_back(std::string(describe(*row).variable_name) + " of " + axes.label_of(input.first) +
                   " is 0");
  }
  return done;
}

client::CallOptions CommandContext::call_options(client::Until until) const {
  client::CallOptions call;
  call.until = until;
  if (timeout) call.timeout = *timeout;
  return call;
}

Outcome execute(const Command& command, CommandContext& context, std::optional<Duration> timeout) {
  ensure(command.row->run != nullptr, "the place of a command without a session is no session");
  context.timeout = timeout;
  context.judge.forget_found();
  const EndOfProgress end_of_progress(context.progress);
  Outcome outcome = context.axes.named(command.row->run(command.arguments, context));
  return command.refusal ? judge_refusal(outcome, *command.refusal, context) : outcome;
}

void show_progress_of(const Expectation& expectation, const client::Axis& axis,
                      CommandContext& context) {
  if (!expectation.within && !expectation.throughout) return;
  context.progress.axis(axis, context.axes.label_of(axis.id()),
                        (expectation.within ? "waiting for " : "checking ") +
                            expectation.object.text + " " + expected_text(expectation));
}

void check_units(const Command& command, CommandContext& context) {
  if (command.row->check_units == nullptr || command.axes.size() != 1) return;
  const auto axis = context.axes.axis(command.axes.front());
  if (axis) command.row->check_units(command.arguments, context, *axis);
}

}  // namespace vdrive::tool
