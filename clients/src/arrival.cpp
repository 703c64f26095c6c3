// SPDX-License-Identifier: Apache-2.0
#include "arrival.hpp"

#include "command_words.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <array>
#include <string>

namespace vdrive::client {

Result<std::uint16_t> controlword_of(AxesCall& call) {
  using namespace literals;
  const std::array controlword{vdrive::describe("ds402_controlword"_object).address};
  const auto present = call.read(controlword);
  if (!present) return present.outcome();
  return static_cast<std::uint16_t>(present->front().front());
}

Outcome check_halt(AxesCall& call) {
  const auto word = controlword_of(call);
  if (!word) return word.outcome();
  if ((*word & Controlword::kHalt) == 0) return {};
  return Outcome::failed("axis " + to_string(call.axis().id) +
                         " was halted before it reached its target");
}

Outcome await_target(AxesCall& call, const Wakeup& wakeup) {
  Outcome reached = call.await_enabled(kTargetReached, call.tick(), target_reached);
  if (reached.kind() == OutcomeKind::failed && is_enabled(call.axis()) && wakeup.is_interrupted()) {
    return Outcome::failed("interrupted; axis " + to_string(call.axis().id) +
                           " goes on to its target");
  }
  return reached ? check_halt(call) : reached;
}

}  // namespace vdrive::client
