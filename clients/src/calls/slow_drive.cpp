// SPDX-License-Identifier: Apache-2.0
#include "calls/slow_drive.hpp"

#include "vdrive/client/command_words.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace literals;

/// @return for each axis, the interval at which the drive evaluates 6040h; 0 if it evaluates every
///         controlword, or if the bench does not state it.
std::vector<std::chrono::milliseconds> loops_of(AxesCall& call) {
  std::vector<std::chrono::milliseconds> loops(call.snapshots().size());
  const auto values = call.read(std::array{kObjectRows["habit_controlword_loop"_object].address});
  for (std::size_t place = 0; values && place < loops.size(); ++place) {
    loops[place] = std::chrono::milliseconds((*values)[place].front());
  }
  return loops;
}

Round round_of_word(const AxesCall& call, std::uint16_t word, std::span<const std::size_t> places) {
  Round round;
  for (const std::size_t place : places) {
    msg::AxisCommand command = call.command_to(place);
    command.members = msg::HAS_DS402_CONTROLWORD;
    command.ds402_controlword = word;
    round.entries.push_back({place, std::move(command)});
  }
  return round;
}

bool is_under_way(const AxisSnapshot& axis) {
  return !is_enabled(axis) && has_no_fault(axis);
}

/// Gives each of these axes the next controlword on its way to Operation enabled.
Outcome send_next_word(AxesCall& call, std::span<const std::size_t> places) {
  Round round;
  std::vector<PowerState> before;
  for (const AxisSnapshot& axis : call.snapshots()) before.push_back(axis.state());
  for (const std::size_t place : places) {
    const auto words = words_to(EachCommand::enable, before[place]);
    if (words.empty()) continue;
    Round own = round_of_word(call, words.front(), {&place, 1});
    round.entries.push_back(std::move(own.entries.front()));
  }
  if (Outcome done = call.put_in_force({&round, 1}); !done) return done;
  const AnswerTime answer_time(call, kLongestLoop);
  return call.await("the next power state", call.tick(), [&](std::size_t place) {
    return answer_time.has_ended() || call.snapshots()[place].state() != before[place] ||
           std::ranges::find(places, place) == places.end();
  });
}

}  // namespace

bool has_answered_enabling(const AxisSnapshot& axis, const AnswerTime& answer_time) {
  const PowerState state = axis.state();
  if (state == PowerState::operation_enabled || is_fault(state)) return true;
  return state != PowerState::switched_on && answer_time.has_ended();
}

Result<bool> enable_step_by_step(AxesCall& call, std::span<const std::size_t> places) {
  std::vector<std::size_t> late(places.begin(), places.end());
  const auto drop_those_there = [&call, &late] {
    std::erase_if(late, [&call](std::size_t place) {
      return !is_under_way(call.snapshots()[place]);
    });
  };
  drop_those_there();
  if (late.empty()) return false;
  const std::vector<std::chrono::milliseconds> loops = loops_of(call);
  std::erase_if(late, [&loops](std::size_t place) {
    return loops[place].count() == 0;
  });
  if (late.empty()) return false;
  const std::size_t longest = words_to(EachCommand::enable, PowerState::quick_stop_active).size();
  for (std::size_t step = 0; step < longest && !late.empty(); ++step) {
    if (Outcome stepped = send_next_word(call, late); !stepped) return stepped;
    drop_those_there();
  }
  return true;
}

Outcome await_controlword_loop(AxesCall& call) {
  const auto loops = loops_of(call);
  const auto longest = *std::ranges::max_element(loops);
  if (longest.count() == 0) return {};
  return call.await_tick("the drive to evaluate the controlword",
                         call.tick() + ticks_of(longest, call.period()));
}

Outcome await_stop_seen(AxesCall& call) {
  const AnswerTime answer_time(call, kLongestLoop);
  return call.await("the quick stop", call.tick(), [&answer_time](const AxisSnapshot& axis) {
    return answer_time.has_ended() || !is_enabled(axis);
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
