// SPDX-License-Identifier: Apache-2.0
#include "engine/frame_schedule.hpp"

#include <algorithm>

namespace vdrive::service {

FrameSchedule::FrameSchedule(FrameAnswers& answers, Counters& counters)
    : answers_(answers), counters_(counters) {}

bool FrameSchedule::insert(std::uint64_t tick, msg::CommandFrame& frame) {
  const bool fits = pending_.insert(tick, frame);
  show_size();
  return fits;
}

bool FrameSchedule::take_due(std::uint64_t tick, msg::CommandFrame& frame) {
  const bool is_due = pending_.take_due(tick, frame);
  if (is_due) show_size();
  return is_due;
}

void FrameSchedule::cancel_all() {
  cancel_if([](const auto& /*head*/, auto /*commands*/) {
    return true;
  });
}

void FrameSchedule::cancel_of_session(std::uint64_t session) {
  cancel_if([session](const auto& head, auto /*commands*/) {
    return head.session == session;
  });
}

void FrameSchedule::cancel_of_axis(std::uint16_t number) {
  cancel_if([number](const auto& /*head*/, auto commands) {
    return std::ranges::any_of(commands, [number](const auto& command) {
      return command.axis == number;
    });
  });
}

bool FrameSchedule::contains(const msg::CommandFrame& frame) const noexcept {
  return pending_.contains(frame.session, frame.sequence_number);
}

template <typename Condition>
void FrameSchedule::cancel_if(Condition condition) {
  pending_.drop_if(condition, [this](const auto& head) {
    answers_.refuse(head, msg::Reason::cancelled);
  });
  show_size();
}

void FrameSchedule::show_size() {
  counters_.pending_frames.set(pending_.size());
}

}  // namespace vdrive::service
