// SPDX-License-Identifier: Apache-2.0
#include "exchange/commands.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

namespace vdrive::client {
namespace {

// A frame for a later tick is answered in that tick.
constexpr Patience kAnswerInItsTick{std::chrono::hours(24), true, true};

static_assert(kMostAxesAtOnce == msg::MAX_AXES_PER_FRAME);
static_assert(kMostObjectsAtOnce == msg::MAX_OBJECTS_PER_REQUEST);

}  // namespace

Commands::Commands(BenchLinks& links, Holdings& holdings, CommandHistory& history,
                   UnansweredFrames& unanswered, Waiter& waiter)
    : links_(links),
      holdings_(holdings),
      history_(history),
      unanswered_(unanswered),
      waiter_(waiter) {}

Outcome Commands::send(SentFrames& sent, std::span<const FrameContent> frames) {
  if (!links_.may_command()) return not_permitted(sent.target);
  const auto sending = holdings_.lock_sending(sent.target.key.number);
  for (const FrameContent& content : frames) {
    if (Outcome outcome = send_one(sent, content); !outcome) return outcome;
  }
  return {};
}

Outcome Commands::send_one(SentFrames& sent, const FrameContent& content) {
  const Target& target = sent.target;
  const auto link = links_.open(target, "commands");
  if (!link) return link.outcome();
  msg::CommandFrame frame = next_frame(target, content);
  const std::uint64_t sequence = frame.sequence_number;
  frame.flags = content.flags | msg::FRAME_WANT_REPLY;
  // Kept before it is sent: the answer may arrive first.
  const msg::CommandFrame& kept =
      unanswered_.add({target.key, sequence}, target.key, std::move(frame));
  sent.sequences.push_back(sequence);
  if (links_.send(*link, kept)) return {};
  return Outcome::lost(name_of(target) + " accepts no more commands");
}

msg::CommandFrame Commands::next_frame(const Target& target, const FrameContent& content) {
  msg::CommandFrame frame = holdings_.next_frame(target.key);
  if (!content.moved.empty()) {
    holdings_.note_running(target.key, content.moved, frame.sequence_number);
  }
  frame.flags = content.flags;
  frame.apply_at_tick = content.apply_at_tick;
  frame.valid_until_tick = content.apply_at_tick;
  frame.axes = content.commands;
  history_.note_frame(target.key, frame);
  return frame;
}

Outcome Commands::send_unawaited(const Target& target, std::span<const FrameContent> frames) {
  if (!links_.may_command()) return not_permitted(target);
  const auto sending = holdings_.lock_sending(target.key.number);
  const auto link = links_.open(target, "commands");
  if (!link) return link.outcome();
  for (const FrameContent& content : frames) {
    if (!links_.send(*link, next_frame(target, content))) {
      return Outcome::lost(name_of(target) + " accepts no more commands");
    }
  }
  return {};
}

Applied Commands::collect(const SentFrames& sent, Outcome outcome) {
  Applied applied;
  for (const std::uint64_t sequence : sent.sequences) {
    const FrameNumber number{sent.target.key, sequence};
    const std::uint64_t apply_at = unanswered_.message(number).apply_at_tick;
    if (outcome) {
      outcome = waiter_.wait(sent.target, apply_at == 0 ? kAnswer : kAnswerInItsTick, [&] {
        return unanswered_.is_answered(number);
      });
    }
    const std::optional<msg::CommandReply> reply = unanswered_.take(number);
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

bool Commands::is_answered(const SentFrames& sent) const {
  return std::ranges::all_of(sent.sequences, [&](std::uint64_t sequence) {
    return unanswered_.is_answered({sent.target.key, sequence});
  });
}

bool Commands::is_refused(const SentFrames& sent) const {
  return std::ranges::any_of(sent.sequences, [&](std::uint64_t sequence) {
    return unanswered_.is_answered({sent.target.key, sequence}, [](const auto& reply) {
      return !reply.refusals.empty();
    });
  });
}

Result<bool> Commands::await_answers(std::span<const SentFrames> sent) {
  const auto any_refused = [&] {
    return std::ranges::any_of(sent, [&](const SentFrames& frames) {
      return is_refused(frames);
    });
  };
  for (const SentFrames& frames : sent) {
    Outcome outcome = waiter_.wait(frames.target, kAnswer, [&] {
      return is_answered(frames) || any_refused();
    });
    if (!outcome) return outcome;
  }
  return !any_refused();
}

}  // namespace vdrive::client
