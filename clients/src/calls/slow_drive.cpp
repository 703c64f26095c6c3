// SPDX-License-Identifier: Apache-2.0
#include "calls/slow_drive.hpp"

#include "base/command_words.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::client {
namespace {

Round round_of_word(const AxesCall& call, std::uint16_t word, std::span<const std::size_t> places) {
  Round round;
  for (const std::size_t place : places) {
    msg::AxisCommand command = call.command_to(place);
    command.members(msg::HAS_DS402_CONTROLWORD);
    command.ds402_controlword(word);
    round.entries.push_back({place, std::move(command)});
  }
  return round;
}

}  // namespace

bool has_answered_enabling(const AxisSnapshot& axis, const AnswerTime& answer_time) {
  const PowerState state = axis.state();
  if (state == PowerState::operation_enabled || is_fault(state)) return true;
  return state != PowerState::switched_on && answer_time.has_ended();
}

Outcome await_enabling(AxesCall& call) {
  const AnswerTime answer_time(call, kLongestLoop);
  return call.await("Operation enabled", call.tick(), [&answer_time](const AxisSnapshot& axis) {
    return has_answered_enabling(axis, answer_time);
  });
}

Outcome hold_reset(AxesCall& call, std::span<const std::size_t> places) {
  const Round held = round_of_word(call, Controlword::kFaultReset, places);
  if (Outcome done = call.put_in_force({&held, 1}); !done) return done;
  const AnswerTime answer_time(call, kLongestReset);
  Outcome seen = call.await("the fault reset", call.tick(), [&](std::size_t place) {
    return answer_time.has_ended() || std::ranges::find(places, place) == places.end() ||
           has_no_fault(call.snapshots()[place]);
  });
  if (!seen) return seen;
  const Round released = round_of_word(call, kDisableVoltage, places);
  return call.put_in_force({&released, 1});
}

}  // namespace vdrive::client
