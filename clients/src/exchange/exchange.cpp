// SPDX-License-Identifier: Apache-2.0
#include "exchange/exchange.hpp"

#include <algorithm>
#include <optional>

namespace vdrive::client {
namespace {

// A frame for a later tick is answered in that tick.
constexpr Patience kAnswerInItsTick{std::chrono::hours(24), true, true};

static_assert(kMostAxesAtOnce == msg::MAX_AXES_PER_FRAME);
static_assert(kMostObjectsAtOnce == msg::MAX_OBJECTS_PER_REQUEST);

}  // namespace

// ---- requests --------------------------------------------------------------------------------

Result<std::uint64_t> Exchange::send(const Target& target, msg::Request request,
                                     std::chrono::milliseconds patience) {
  const auto link = links_.open(target, "requests", patience);
  if (!link) return link.outcome();
  const std::uint64_t number = ++last_number_;
  request.client = session_;
  request.request_id = number;
  request.bench = target.key.number;
  request.incarnation = target.key.incarnation;
  request.session = session_;
  // Stored before it is sent: the reply may arrive first.
  const msg::Request& kept = unanswered_requests().add(number, target.key, std::move(request));
  if (links_.send(*link, kept)) return number;
  (void)unanswered_requests().take(number);
  return Outcome::lost(name_of(target) + " accepts no requests: its queue is full");
}

Result<RequestAnswer> Exchange::await(const Target& target, std::uint64_t number,
                                      const Patience& patience) {
  Outcome outcome = links_.wait(target, patience, [&] {
    return unanswered_requests().is_answered(number);
  });
  std::optional<RequestAnswer> reply = unanswered_requests().take(number);
  if (!outcome) return outcome;
  return std::move(*reply);
}

Result<RequestAnswer> Exchange::request(const Target& target, msg::Request message,
                                        std::string_view what, Silence silence) {
  const auto number = send(target, std::move(message));
  if (!number) return number.outcome();
  Patience patience = kAnswer;
  patience.silence = silence;
  auto reply = await(target, *number, patience);
  if (!reply) return reply;
  if (reply->reason != msg::Reason::none) return refusal_of(target, *reply, what);
  return reply;
}

SentRequests Exchange::send_all(const Target& target, std::vector<msg::Request> requests) {
  SentRequests sent(*this, target);
  for (msg::Request& request : requests) {
    const auto number = send(target, std::move(request));
    sent.sending_ = number.outcome();
    if (!number) break;
    sent.numbers_.push_back(*number);
  }
  return sent;
}

SentRequests::~SentRequests() {
  for (const std::uint64_t number : numbers_) (void)exchange_->unanswered_requests().take(number);
}

Result<std::vector<RequestAnswer>> SentRequests::await(std::string_view what) {
  Outcome outcome = sending_;
  std::vector<RequestAnswer> replies;
  auto number = numbers_.begin();
  while (outcome && number != numbers_.end()) {
    auto reply = exchange_->await(target_, *number++, kAnswer);
    outcome = !reply                               ? reply.outcome()
              : reply->reason != msg::Reason::none ? refusal_of(target_, *reply, what)
                                                   : Outcome();
    if (outcome) replies.push_back(std::move(*reply));
  }
  numbers_.erase(numbers_.begin(), number);
  if (!outcome) return outcome;
  return replies;
}

// ---- command frames --------------------------------------------------------------------------

Outcome Exchange::send(SentFrames& sent, std::span<const FrameContent> frames) {
  if (!links_.may_command()) return not_permitted(sent.target);
  const auto sending = held_axes_.lock_sending(sent.target.key.number);
  for (const FrameContent& content : frames) {
    if (Outcome outcome = send_one(sent, content); !outcome) return outcome;
  }
  return {};
}

Outcome Exchange::send_one(SentFrames& sent, const FrameContent& content) {
  const Target& target = sent.target;
  const auto link = links_.open(target, "commands");
  if (!link) return link.outcome();
  msg::CommandFrame frame = next_frame(target, content);
  const std::uint64_t sequence = frame.sequence_number;
  frame.flags = content.flags | msg::FRAME_WANT_REPLY;
  // Stored before it is sent: the answer may arrive first.
  const msg::CommandFrame& kept =
      unanswered_frames().add({target.key, sequence}, target.key, std::move(frame));
  sent.sequences.push_back(sequence);
  if (links_.send(*link, kept)) return {};
  return Outcome::lost(name_of(target) + " accepts no commands: its queue is full");
}

msg::CommandFrame Exchange::next_frame(const Target& target, const FrameContent& content) {
  msg::CommandFrame frame = held_axes_.next_frame(target.key);
  if (!content.moved.empty()) {
    held_axes_.note_running(target.key, content.moved, frame.sequence_number);
  }
  frame.flags = content.flags;
  frame.apply_at_tick = content.apply_at_tick;
  frame.valid_until_tick = content.apply_at_tick;
  frame.axes = content.commands;
  history_.note_frame(target.key, frame);
  return frame;
}

Outcome Exchange::send_unawaited(const Target& target, std::span<const FrameContent> frames) {
  if (!links_.may_command()) return not_permitted(target);
  const auto sending = held_axes_.lock_sending(target.key.number);
  const auto link = links_.open(target, "commands");
  if (!link) return link.outcome();
  for (const FrameContent& content : frames) {
    if (!links_.send(*link, next_frame(target, content))) {
      return Outcome::lost(name_of(target) + " accepts no commands: its queue is full");
    }
  }
  return {};
}

Applied Exchange::collect(const SentFrames& sent, Outcome outcome) {
  Applied applied;
  for (const std::uint64_t sequence : sent.sequences) {
    const FrameNumber number{sent.target.key, sequence};
    const std::uint64_t apply_at = unanswered_frames().message(number).apply_at_tick;
    if (outcome) {
      outcome = links_.wait(sent.target, apply_at == 0 ? kAnswer : kAnswerInItsTick, [&] {
        return unanswered_frames().is_answered(number);
      });
    }
    const std::optional<msg::CommandReply> reply = unanswered_frames().take(number);
    if (!outcome) continue;
    if (!reply->refusals.empty()) {
      if (applied.outcome) applied.outcome = refusal_of(sent.target, *reply, apply_at);
    } else {
      applied.tick = std::max(applied.tick, reply->tick);
      const auto& ignored = reply->ignored_set_points;
      applied.ignored_set_points.insert(applied.ignored_set_points.end(), ignored.begin(),
                                        ignored.end());
    }
  }
  if (!outcome) applied.outcome = std::move(outcome);
  return applied;
}

bool Exchange::is_answered(const SentFrames& sent) const {
  return std::ranges::all_of(sent.sequences, [&](std::uint64_t sequence) {
    return unanswered_frames().is_answered({sent.target.key, sequence});
  });
}

bool Exchange::is_refused(const SentFrames& sent) const {
  return std::ranges::any_of(sent.sequences, [&](std::uint64_t sequence) {
    return unanswered_frames().is_answered({sent.target.key, sequence}, [](const auto& reply) {
      return !reply.refusals.empty();
    });
  });
}

Result<bool> Exchange::await_answers(std::span<const SentFrames> sent) {
  const auto any_refused = [&] {
    return std::ranges::any_of(sent, [&](const SentFrames& frames) {
      return is_refused(frames);
    });
  };
  for (const SentFrames& frames : sent) {
    Outcome outcome = links_.wait(frames.target, kAnswer, [&] {
      return is_answered(frames) || any_refused();
    });
    if (!outcome) return outcome;
  }
  return !any_refused();
}

}  // namespace vdrive::client
