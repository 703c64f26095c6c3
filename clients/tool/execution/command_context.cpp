// SPDX-License-Identifier: Apache-2.0
#include "execution/command_context.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/number_text.hpp"

#include <string>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

/// `refused`: it passes where the command is refused with this code.
Outcome judge_refusal(const Outcome& outcome, std::uint32_t code, CommandContext& context) {
  if (outcome.kind() == OutcomeKind::refused && outcome.code() == code) return {};
  const std::string actual = outcome ? "accepted" : outcome.message();
  context.judge.set_found({{"expected", hex(code, 8)}, {"actual", actual}});
  return Outcome::failed("expected the refusal " + hex(code, 8) + ", actual: " + actual);
}

}  // namespace

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

void tell_progress_of(const Expectation& expectation, const client::Axis& axis,
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
