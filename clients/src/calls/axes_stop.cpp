// SPDX-License-Identifier: Apache-2.0
#include "calls/axes_stop.hpp"

#include "base/command_words.hpp"
#include "calls/slow_drive.hpp"
#include "session/session_core.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

namespace vdrive::client {

AxesStop::AxesStop(SessionCore& core, AxesCall& call)
    : core_(core), call_(call), in_progress_(core.wakeup) {}

Outcome AxesStop::begin(std::chrono::nanoseconds timeout) {
  if (Outcome begun = call_.begin(timeout); !begun) return begun;
  held_.assign(call_.snapshots().size(), false);
  for (const BenchPart& part : call_.axes().parts()) {
    if (!core_.links.may_command()) return not_permitted(part.target);
    if (call_.axes().caller() == Caller::axis && core_.discovery.is_paused(part.target.key)) {
      return Outcome::failed(paused_text(part.target));
    }
    for (const std::size_t place : part.bench->places) {
      held_[place] = call_.has_control_of(part.target, call_.snapshots()[place]);
    }
  }
  return {};
}

Outcome AxesStop::acquire_free() {
  for (BenchPart& part : call_.axes().parts()) {
    if (Outcome taken = acquire_free_of(part); !taken) return taken;
  }
  return {};
}

Outcome AxesStop::acquire_free_of(BenchPart& part) {
  constexpr std::uint32_t kLocalControl = wire_code(AbortCode::refused_local_control);
  std::vector<std::size_t> free;
  std::ranges::copy_if(part.bench->places, std::back_inserter(free), [this](std::size_t place) {
    return call_.snapshots()[place].owner_session == 0;
  });
  if (free.empty()) return {};
  std::vector<std::uint16_t> axes;
  axes.reserve(free.size());
  for (const std::size_t place : free) axes.push_back(call_.snapshots()[place].id.axis);
  Outcome taken = core_.control.acquire(part.target, axes);
  // Another session was faster: what it owns is stopped without control.
  if (taken.code() == kLocalControl) return {};
  if (!taken) return call_.axes().note_lost(part, std::move(taken));
  for (const std::size_t place : free) held_[place] = true;
  return {};
}

Answers AxesStop::exchange(const Round& round, Timing timing) {
  Answers answers;
  if (const std::vector<Round> own = held_of(round); !own.empty()) {
    answers = call_.exchange(own, timing);
  }
  for (BenchPart& part : call_.axes().parts()) {
    if (!part.is_lost()) stop_others(part, round, answers);
  }
  call_.note_in_force(answers.tick);
  return answers;
}

/// @return the round for the axes that this session owns, in rounds that fit into a frame.
std::vector<Round> AxesStop::held_of(const Round& round) const {
  std::vector<Round> own;
  for (const Round::Entry& entry : round.entries) {
    if (!held_[entry.place]) continue;
    if (own.empty() || own.back().entries.size() == msg::MAX_AXES_PER_FRAME) own.emplace_back();
    own.back().entries.push_back(entry);
  }
  return own;
}

void AxesStop::stop_others(BenchPart& part, const Round& round, Answers& answers) {
  std::vector<std::uint16_t> others;
  for (const Round::Entry& entry : round.entries) {
    const AxisId& id = call_.axes().layout().axes[entry.place];
    if (id.bench == part.bench->number && !held_[entry.place]) others.push_back(id.axis);
  }
  if (others.empty()) return;
  const std::uint16_t word = round.entries.front().command.ds402_controlword;
  const auto stopped = core_.control.stop(part.target, others, word);
  if (stopped) {
    answers.tick = std::max(answers.tick, *stopped);
  } else if (answers.outcome) {
    answers.outcome = call_.axes().note_lost(part, stopped.outcome());
  }
}

Outcome AxesStop::put_in_force(const Round& round) {
  const Answers answers = exchange(round, Timing::at_once);
  if (!answers.outcome) return answers.outcome;
  return call_.await_tick("the stop to be in force", answers.tick);
}

Outcome AxesStop::quick_stop(Until until) {
  const Round round = call_.round_of(kQuickStop, [](const AxisSnapshot& axis) {
    return !is_fault(axis.state());
  });
  const Answers answers = exchange(round, Timing::at_once);
  if (!answers.outcome) return answers.outcome;
  Outcome seen = call_.await_tick("the quick stop", answers.tick);
  if (!seen || until != Until::done) return seen;
  seen = await_stop_seen(call_);
  return seen ? call_.await_quick_stops() : seen;
}

}  // namespace vdrive::client
