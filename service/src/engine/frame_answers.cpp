// SPDX-License-Identifier: Apache-2.0
#include "engine/frame_answers.hpp"

#include <algorithm>

namespace vdrive::service {

FrameAnswers::FrameAnswers(const BenchIdentity& identity, const BenchClock& clock,
                           BenchEvents& events, Ring<StoredCommandReply>& queue, Counters& counters)
    : identity_(identity), clock_(clock), events_(events), queue_(queue), counters_(counters) {
  refusal_.refusals.resize(1);
  repeated_.refusals.reserve(msg::MAX_AXES_PER_FRAME);
  repeated_.ignored_set_points.reserve(msg::MAX_AXES_PER_FRAME);
}

bool FrameAnswers::is_of_this_run(const msg::CommandFrame& frame) const noexcept {
  return frame.incarnation == identity_.incarnation;
}

Fate FrameAnswers::fate_of(const msg::CommandFrame& frame) const noexcept {
  return memory_.fate_of(frame.session, frame.sequence_number);
}

void FrameAnswers::take(const msg::CommandFrame& frame) {
  memory_.take(frame.session, frame.sequence_number);
}

void FrameAnswers::repeat(const msg::CommandFrame& frame) {
  memory_.answer_to(frame.session, frame.sequence_number)->show(repeated_);
  post(repeated_);
}

void FrameAnswers::send(const msg::CommandFrame& frame, msg::CommandReply& reply) {
  reply.bench = identity_.bench;
  reply.incarnation = identity_.incarnation;
  reply.session = frame.session;
  reply.sequence_number = frame.sequence_number;
  reply.tick = clock_.next_tick();
  if (is_of_this_run(frame)) {
    if (auto* const kept = memory_.keep(frame.session, frame.sequence_number)) {
      kept->keep(reply);
    }
  }
  post(reply);
}

/// Uses a separate reply, because a frame that halts cancels others while its own answer is built.
void FrameAnswers::refuse(const msg::CommandFrame& frame, Reason reason) {
  refusal_.refusals.front().reason = reason.on_wire();
  counters_.frames_refused.add();
  events_.report(
      {.kind = msg::EventKind::refused,
       .session = frame.session,
       .code = reason.code(),
       .detail = RefusedMessage{.number = frame.sequence_number,
                                .late_by = reason == msg::Reason::too_late ? lateness(frame) : 0}});
  send(frame, refusal_);
}

/// @return by how many ticks the frame is late for the next tick.
std::uint64_t FrameAnswers::lateness(const msg::CommandFrame& frame) const noexcept {
  const std::uint64_t next = clock_.next_tick();
  const auto past = [next](std::uint64_t tick) {
    return tick != 0 && tick < next ? next - tick : 0;
  };
  return std::max(past(frame.apply_at_tick), past(frame.valid_until_tick));
}

void FrameAnswers::post(const msg::CommandReply& reply) {
  StoredCommandReply* const slot = queue_.free_slot();
  if (slot == nullptr) {
    counters_.queue_overflows.add();
    return;
  }
  slot->keep(reply);
  queue_.push();
}

}  // namespace vdrive::service
