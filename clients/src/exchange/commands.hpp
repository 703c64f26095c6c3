// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "exchange/bench_links.hpp"
#include "exchange/command_history.hpp"
#include "exchange/holdings.hpp"
#include "exchange/unanswered.hpp"
#include "exchange/waiter.hpp"
#include "presence/target.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace vdrive::client {

/// What one command frame carries.
struct FrameContent {
  std::vector<msg::AxisCommand> commands;
  std::uint64_t apply_at_tick = 0;     ///< 0 = the next; a frame that misses its tick is refused
  std::uint32_t flags = 0;             ///< FRAME_..., beside the wish for a reply
  std::vector<std::uint16_t> moved{};  ///< axes that run from then on: see Holdings
};

/// Frames that were sent to one bench.
struct SentFrames {
  Target target;
  std::vector<std::uint64_t> sequences;
};

/// What became of command frames.
struct Applied {
  Outcome outcome;         ///< the first refusal, if any
  std::uint64_t tick = 0;  ///< in which the last accepted one is in force; 0 = none was
  std::vector<std::uint16_t> ignored_set_points;  ///< axes that did not take theirs
};

/// Sends command frames and collects their answers. Thread-safe.
class Commands {
 public:
  Commands(BenchLinks& links, Holdings& holdings, CommandHistory& history,
           UnansweredFrames& unanswered, Waiter& waiter);

  /// Sends frames in order, with no frame of another thread between them, and adds each to what was
  /// sent, also before a failure.
  Outcome send(SentFrames& sent, std::span<const FrameContent> frames);

  /// Sends frames without waiting. Only a refused frame is answered; no call waits for this answer.
  Outcome send_unawaited(const Target& target, std::span<const FrameContent> frames);

  /// Waits for the answers to these frames. A frame that waits for its tick is answered then.
  /// @param outcome of the sending; when it failed nothing is waited for
  Applied collect(const SentFrames& sent, Outcome outcome);

  /// Waits until all of these are answered, or one of them is refused.
  /// @return whether none was refused.
  Result<bool> await_answers(std::span<const SentFrames> sent);

 private:
  Outcome send_one(SentFrames& sent, const FrameContent& content);
  msg::CommandFrame next_frame(const Target& target, const FrameContent& content);
  [[nodiscard]] bool is_answered(const SentFrames& sent) const;
  [[nodiscard]] bool is_refused(const SentFrames& sent) const;

  BenchLinks& links_;
  Holdings& holdings_;
  CommandHistory& history_;
  UnansweredFrames& unanswered_;
  Waiter& waiter_;
};

}  // namespace vdrive::client
