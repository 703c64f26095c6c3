// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "exchange/bench_links.hpp"
#include "exchange/command_history.hpp"
#include "exchange/held_axes.hpp"
#include "presence/target.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive_messages.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::client {

class Exchange;

/// Requests sent to one bench together. Answers that are not awaited are dropped.
class SentRequests {
 public:
  SentRequests(Exchange& exchange, const Target& target) : exchange_(&exchange), target_(target) {}

  ~SentRequests();
  SentRequests(SentRequests&&) noexcept = default;
  SentRequests(const SentRequests&) = delete;
  SentRequests& operator=(const SentRequests&) = delete;
  SentRequests& operator=(SentRequests&&) = delete;

  /// @param what names the requests in messages, such as "read of axis 1.1"
  /// @return the replies in the same order, or the first refusal.
  Result<std::vector<RequestAnswer>> await(std::string_view what);

 private:
  friend class Exchange;
  Exchange* exchange_;
  Target target_;
  std::vector<std::uint64_t> numbers_;
  Outcome sending_;
};

struct FrameContent {
  std::vector<msg::AxisCommand> commands;
  std::uint64_t apply_at_tick = 0;     ///< 0 = the next; a frame that misses its tick is refused
  std::uint32_t flags = 0;             ///< FRAME_..., in addition to the request for a reply
  std::vector<std::uint16_t> moved{};  ///< axes that run from then on: see HeldAxes
};

struct SentFrames {
  Target target;
  std::vector<std::uint64_t> sequences;
};

/// The result of command frames.
struct Applied {
  Outcome outcome;         ///< the first refusal, if any
  std::uint64_t tick = 0;  ///< in which the last accepted one takes effect; 0 = none was accepted
  std::vector<std::uint16_t> ignored_set_points;  ///< axes that ignored theirs
};

/// Sends requests and command frames to benches, and waits for their answers. Thread-safe.
class Exchange {
 public:
  Exchange(std::uint64_t session, BenchLinks& links, HeldAxes& held_axes, CommandHistory& history)
      : session_(session), links_(links), held_axes_(held_axes), history_(history) {}

  // ---- requests

  /// Sends a request and waits for its reply. Fills in sender and receiver.
  /// @param what names the request in messages, such as "read of axis 1.1"
  Result<RequestAnswer> request(const Target& target, msg::Request message, std::string_view what,
                                Silence silence = Silence::ends_call);

  /// Sends several requests, stopping at the first that cannot be sent.
  SentRequests send_all(const Target& target, std::vector<msg::Request> requests);

  /// Sends a request.
  /// @param patience wall time to wait for the match with a bench that has reconnected
  /// @return its number, for await().
  Result<std::uint64_t> send(const Target& target, msg::Request request,
                             std::chrono::milliseconds patience = kMatch);

  /// Waits for the reply to a request, which may be a refusal.
  Result<RequestAnswer> await(const Target& target, std::uint64_t number, const Patience& patience);

  /// Call this after reading the axes of an answer: a later answer reuses their memory.
  void reuse(RequestAnswer& answer) { links_.reuse(std::move(answer.axes)); }

  // ---- command frames

  /// Sends frames in order, without a frame of another thread in between, and appends each to
  /// `sent`, including those sent before a failure.
  Outcome send(SentFrames& sent, std::span<const FrameContent> frames);

  /// Sends frames without waiting. Only a refused frame is answered, and no call waits for that
  /// answer.
  Outcome send_unawaited(const Target& target, std::span<const FrameContent> frames);

  /// Waits for the answers to these frames. A frame that waits for its tick is answered in that
  /// tick.
  /// @param outcome of sending them; if that failed, this does not wait
  Applied collect(const SentFrames& sent, Outcome outcome);

  /// Waits until all of these frames are answered, or one of them is refused.
  /// @return whether none was refused.
  Result<bool> await_answers(std::span<const SentFrames> sent);

 private:
  friend class SentRequests;

  Outcome send_one(SentFrames& sent, const FrameContent& content);
  msg::CommandFrame next_frame(const Target& target, const FrameContent& content);
  [[nodiscard]] bool is_answered(const SentFrames& sent) const;
  [[nodiscard]] bool is_refused(const SentFrames& sent) const;

  [[nodiscard]] UnansweredRequests& unanswered_requests() const {
    return links_.unanswered().requests;
  }

  [[nodiscard]] UnansweredFrames& unanswered_frames() const { return links_.unanswered().frames; }

  const std::uint64_t session_;
  BenchLinks& links_;
  HeldAxes& held_axes_;
  CommandHistory& history_;
  std::atomic<std::uint64_t> last_number_ = 0;
};

}  // namespace vdrive::client
