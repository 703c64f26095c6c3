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

/// Runs a bench in lock-step with `step` requests. One thread handles the arrivals in their order,
/// steps, and writes replies and status itself, so that a request changes threads only once.
/// StepRequests decides how far time may pass, and which step is answered when.
class LockstepDriver {
 public:
  static constexpr std::chrono::milliseconds kIdleInterval{20};
  /// How often `run` tries to send a reply whose reader has not been discovered: the doorbell does
  /// not ring when the reader appears.
  static constexpr std::chrono::milliseconds kReplyInterval{1};
  static constexpr std::chrono::milliseconds kCheckInterval{100};
  static constexpr TokenBucket::Rate kStatusRate{.per_second = 1'000.0, .burst = 64.0};
  /// The maximum number of requests held back while a step waits for its frames. Further ones wait
  /// in the inbox.
  static constexpr std::size_t kMostDeferred = 1'024;

  /// @param stop ends `run`
  /// @param doorbell rings for arrivals and for the stop
  LockstepDriver(const Configuration& configuration, BenchEngine& engine, Inbox& inbox,
                 Outbox& outbox, StatusPublisher& status, ReplyPublisher& replies,
                 const std::atomic<bool>& stop, Doorbell& doorbell);

  /// Works until `stop`, in a separate thread.
  void run();

  // The parts of `run`, for a bench without a thread:

  /// Publishes the first status.
  void begin();

  /// Handles the oldest arrival, lets time pass as far as the steps allow, and answers.
  /// @return whether there may be more to do
  bool round();

  /// Refuses the waiting steps.
  void end();

  /// @return the count of rounds and ticks, which grows while the driver makes progress.
  [[nodiscard]] const Counter& beats() const noexcept { return beats_; }

 private:
  using Clock = std::chrono::steady_clock;

  bool handle_next(Clock::time_point now);
  bool handle_frames_only(Clock::time_point now);
  void handle(Arrival& arrival, Clock::time_point now);
  bool advance_time(Clock::time_point now);
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
  std::deque<Arrival> deferred_;  ///< requests that arrived while a step waited for its frames
  Clock::time_point next_check_{};
  Counter beats_;
  TokenBucket shown_ticks_{kStatusRate};
};

}  // namespace vdrive::service
