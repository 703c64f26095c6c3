// SPDX-License-Identifier: Apache-2.0
#include "engine/command_frames.hpp"

#include <algorithm>

namespace vdrive::service {
namespace {

constexpr std::uint32_t kKnownFlags =
    msg::FRAME_ALL_OR_NOTHING | msg::FRAME_CANCEL_PENDING | msg::FRAME_WANT_REPLY;

}  // namespace

CommandFrames::CommandFrames(const BenchClock& clock, const BenchBrake& brake, Masters& masters,
                             FrameSchedule& schedule, FrameAnswers& answers,
                             FrameApplication& application, Counters& counters)
    : clock_(clock),
      brake_(brake),
      masters_(masters),
      schedule_(schedule),
      answers_(answers),
      application_(application),
      counters_(counters),
      furthest_ahead_(clock.ticks_in(kFurthestAhead)) {
  due_frame_.axes.reserve(msg::MAX_AXES_PER_FRAME);
}

void CommandFrames::handle(Arrival& arrival) {
  auto& frame = arrival.frame;
  counters_.frames_received.add();
  if (const Reason reason = check_sender(frame); reason != msg::Reason::none) {
    refuse(frame, reason);
    return;
  }
  SessionRecord* const record = masters_.admit(frame.session);
  if (record == nullptr) {
    refuse(frame, msg::Reason::queue_full);
    return;
  }
  record->last_message_tick = clock_.tick();
  if (answer_repeat(frame)) return;
  record->last_sequence = std::max(record->last_sequence, frame.sequence_number);
  if (const Reason reason = check(arrival, *record); reason != msg::Reason::none) {
    refuse(frame, reason);
    return;
  }
  const bool cancels = (frame.flags & msg::FRAME_CANCEL_PENDING) != 0;
  if (cancels || !frame.axes.empty()) record->last_command = frame.sequence_number;
  if (cancels) schedule_.cancel_of_session(frame.session);
  if (frame.apply_at_tick <= clock_.next_tick()) {
    application_.apply(frame);
  } else if (!schedule_.insert(frame.apply_at_tick, frame)) {
    refuse(frame, msg::Reason::queue_full);
  }
}

void CommandFrames::apply_due() {
  while (schedule_.take_due(clock_.next_tick(), due_frame_)) {
    // After a jump of the tick number, a frame may have expired.
    const std::uint64_t valid_until = due_frame_.valid_until_tick;
    if (valid_until != 0 && valid_until < clock_.next_tick()) {
      refuse(due_frame_, msg::Reason::too_late);
    } else {
      application_.apply(due_frame_);
    }
  }
}

bool CommandFrames::has_arrived(std::uint64_t session, std::uint64_t sequence) const noexcept {
  if (sequence == 0) return true;
  const SessionRecord* const record = masters_.find(session);
  return record != nullptr && record->last_sequence >= sequence;
}

void CommandFrames::refuse(const msg::CommandFrame& frame, Reason reason) {
  answers_.refuse(frame, reason);
  application_.record_refused(frame, reason);
}

/// A frame that is refused here does not belong to a session of this incarnation, so it is not
/// remembered.
Reason CommandFrames::check_sender(const msg::CommandFrame& frame) const noexcept {
  if (!answers_.is_of_this_run(frame)) return msg::Reason::wrong_incarnation;
  if (frame.session == 0) return msg::Reason::bad_session;
  return msg::Reason::none;
}

/// After its connection to the bench was interrupted, a client repeats unanswered frames.
/// @return whether the frame has arrived before
bool CommandFrames::answer_repeat(const msg::CommandFrame& frame) {
  switch (answers_.fate_of(frame)) {
    case Fate::unknown:
      answers_.take(frame);
      return false;
    case Fate::taken:  // it waits for its tick, or wants no answer
      break;
    case Fate::answered:
      answers_.repeat(frame);
      break;
    case Fate::forgotten:
      if (!schedule_.contains(frame)) answers_.refuse(frame, msg::Reason::too_late);
      break;
  }
  return true;
}

Reason CommandFrames::check(const Arrival& arrival, const SessionRecord& record) const {
  const auto& frame = arrival.frame;
  // Commands keep their order: a command older than the last accepted one is too late. A keep-alive
  // does not count, so a command that it overtook still acts.
  if (frame.sequence_number <= record.last_command) return msg::Reason::too_late;
  if (record.epoch == 0 && frame.epoch == 0) return msg::Reason::not_owner;
  if (frame.epoch != record.epoch) return msg::Reason::stale_epoch;
  if ((frame.flags & ~kKnownFlags) != 0) return msg::Reason::unknown_flags;
  if (brake_.is_engaged() && !frame.axes.empty()) return msg::Reason::shutting_down;
  return arrival.refusal != msg::Reason::none ? arrival.refusal : check_time(frame);
}

Reason CommandFrames::check_time(const msg::CommandFrame& frame) const {
  const std::uint64_t apply_at =
      frame.apply_at_tick == 0 ? clock_.next_tick() : frame.apply_at_tick;
  if (apply_at <= clock_.tick()) return msg::Reason::too_late;
  if (apply_at - clock_.tick() > furthest_ahead_) return msg::Reason::too_far_ahead;
  const bool expires_before = frame.valid_until_tick != 0 && frame.valid_until_tick < apply_at;
  if (expires_before) return msg::Reason::too_late;
  return msg::Reason::none;
}

}  // namespace vdrive::service
