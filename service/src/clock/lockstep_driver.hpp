// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "engine/bench_engine.hpp"
#include "publish/reply_publisher.hpp"
#include "publish/status_publisher.hpp"
#include "seam/doorbell.hpp"
#include "seam/queues.hpp"
#include "vdrive/token_bucket.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace vdrive::service {

/// Lets `step` requests advance a bench. One thread takes what arrived in its order, steps, and
/// writes replies and status itself: a request changes hands once. How far time may pass, and who
/// is answered when, is the business of StepRequests.
class LockstepDriver {
 public:
  static constexpr std::chrono::milliseconds kIdleInterval{20};
  /// A reply waits for its reader, and no ring says that the reader has come.
  static constexpr std::chrono::milliseconds kReplyInterval{1};
  static constexpr std::chrono::milliseconds kCheckInterval{100};
  static constexpr TokenBucket::Rate kStatusRate{.per_second = 1'000.0, .burst = 64.0};
  /// Requests behind a step that waits for its frames; further ones are refused.
  static constexpr std::size_t kMostDeferred = 1'024;

  /// @param stop ends `run`
  /// @param doorbell rings for arrivals and for the stop
  LockstepDriver(const Configuration& configuration, BenchEngine& engine, Inbox& inbox,
                 Outbox& outbox, StatusPublisher& status, ReplyPublisher& replies,
                 const std::atomic<bool>& stop, Doorbell& doorbell);

  /// Works until the stop, in a thread of its own.
  void run();

  // The parts of `run`, for a bench without a thread:

  /// Shows the axes for the first time.
  void begin();

  /// Takes what arrived first, lets time pass as far as the steps allow, and answers.
  /// @return whether there may be more.
  bool round();

  /// Refuses the steps that wait.
  void end();

  /// Counts rounds and ticks: it grows while the driver makes progress.
  [[nodiscard]] const Counter& beats() const noexcept { return beats_; }

 private:
  using Clock = std::chrono::steady_clock;

  bool handle_next(Clock::time_point now);
  bool handle_frames_only(Clock::time_point now);
  void handle(Arrival& arrival, Clock::time_point now);
  bool pass_time(Clock::time_point now);
  void run_ticks(std::uint64_t ticks);
  void answer_steps(Clock::time_point now);
  void remove_absent(Clock::time_point now);

  template <typename IsDone>
  void deliver_until(const IsDone& is_done);

  void deliver() { replies_.deliver(inbox_, outbox_); }

  [[nodiscard]] bool may_publish();
  void publish_status(bool repeated = false);
  void publish_queued();
  void idle();

  BenchEngine& engine_;
  StepRequests& steps_;
  Inbox& inbox_;
  Outbox& outbox_;
  StatusPublisher& status_;
  ReplyPublisher& replies_;
  const std::atomic<bool>& stop_;
  Doorbell& doorbell_;
  std::uint32_t status_every_;
  std::deque<Arrival> deferred_;  ///< requests that came while a step waited for its commands
  Clock::time_point next_check_{};
  Counter beats_;
  TokenBucket shown_ticks_{kStatusRate};
};

}  // namespace vdrive::service
