// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "doorbell.hpp"
#include "reply_publisher.hpp"
#include "status_publisher.hpp"
#include "vdrive/service/bench_engine.hpp"
#include "vdrive/service/configuration.hpp"
#include "vdrive/service/queues.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>

namespace vdrive::service {

/// Lets `step` requests advance a bench. One thread takes what arrived in its order, steps, and
/// writes replies and status itself: a request changes hands once.
class LockstepDriver {
 public:
  static constexpr std::chrono::seconds kLongestWaitForCommands{1};
  static constexpr std::chrono::milliseconds kIdleInterval{20};
  static constexpr std::chrono::milliseconds kReplyInterval{1};
  static constexpr double kStatusPerSecond = 1'000.0;
  static constexpr double kStatusBurst = 64.0;
  static constexpr std::size_t kMostDeferred = 1'024;

  LockstepDriver(const Configuration& configuration, BenchEngine& engine, Inbox& inbox,
                 Outbox& outbox, StatusPublisher& status, ReplyPublisher& replies);

  /// Works until `stop`. `doorbell` rings for arrivals and for the stop.
  void run(const std::atomic<bool>& stop, Doorbell& doorbell);

 private:
  using Clock = std::chrono::steady_clock;

  bool handle_next(const std::atomic<bool>& stop, Doorbell& doorbell);
  void handle(Arrival& arrival, const std::atomic<bool>& stop, Doorbell& doorbell);
  void step(Arrival& arrival, const std::atomic<bool>& stop, Doorbell& doorbell);
  [[nodiscard]] bool wait_for_commands(const msg::Request& request, const std::atomic<bool>& stop,
                                       Doorbell& doorbell);
  bool take_frames();
  void run_ticks(const msg::Request& request, const std::atomic<bool>& stop);
  [[nodiscard]] bool may_publish();
  void publish_status(bool repeated = false);
  void idle();

  BenchEngine& engine_;
  Inbox& inbox_;
  Outbox& outbox_;
  StatusPublisher& status_;
  ReplyPublisher& replies_;
  std::uint32_t status_every_;
  std::deque<Arrival> deferred_;  ///< requests that came while a step waited for its commands
  double status_budget_ = kStatusBurst;
  Clock::time_point refilled_{};
};

}  // namespace vdrive::service
