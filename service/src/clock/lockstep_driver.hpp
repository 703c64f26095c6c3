// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clock/stepper_table.hpp"
#include "configuration/configuration.hpp"
#include "engine/bench_engine.hpp"
#include "publish/reply_publisher.hpp"
#include "publish/status_publisher.hpp"
#include "seam/doorbell.hpp"
#include "seam/queues.hpp"
#include "vdrive/token_bucket.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <vector>

namespace vdrive::service {

/// Lets `step` requests advance a bench. One thread takes what arrived in its order, steps, and
/// writes replies and status itself: a request changes hands once.
///
/// While no session has joined the clock every step passes time at once. With steppers, a step
/// waits aside until time has reached what its session grants; everything else continues meanwhile.
class LockstepDriver {
 public:
  static constexpr std::chrono::seconds kLongestWaitForCommands{1};
  static constexpr std::chrono::seconds kLongestWaitForSteppers{1};
  static constexpr std::chrono::milliseconds kIdleInterval{20};
  static constexpr std::chrono::milliseconds kReplyInterval{1};
  static constexpr std::chrono::milliseconds kCheckInterval{100};
  static constexpr TokenBucket::Rate kStatusRate{.per_second = 1'000.0, .burst = 64.0};
  static constexpr std::size_t kMostDeferred = 1'024;

  LockstepDriver(const Configuration& configuration, BenchEngine& engine, Inbox& inbox,
                 Outbox& outbox, StatusPublisher& status, ReplyPublisher& replies,
                 Counters& counters);

  /// Works until `stop`. `doorbell` rings for arrivals and for the stop.
  void run(const std::atomic<bool>& stop, Doorbell& doorbell);

  /// Counts rounds and ticks: it grows while the driver makes progress.
  [[nodiscard]] const Counter& beats() const noexcept { return beats_; }

 private:
  using Clock = std::chrono::steady_clock;

  /// A step while there are steppers: first it waits for its command frames, then for time.
  struct WaitingStep {
    Arrival arrival;
    Clock::time_point deadline;
    bool is_granted = false;
    bool is_of_stepper = false;  ///< holds when `is_granted`
    std::uint64_t aim = 0;       ///< tick that it is answered in; holds when `is_granted`
  };

  bool handle_next(const std::atomic<bool>& stop, Doorbell& doorbell);
  void handle(Arrival& arrival, const std::atomic<bool>& stop, Doorbell& doorbell);
  void step(Arrival& arrival, const std::atomic<bool>& stop, Doorbell& doorbell);
  void step_at_once(const Arrival& arrival, const std::atomic<bool>& stop, Doorbell& doorbell);
  [[nodiscard]] bool wait_for_commands(const msg::Request& request, const std::atomic<bool>& stop,
                                       Doorbell& doorbell);
  void answer(const Arrival& arrival, std::uint32_t reason, std::uint64_t missing_stepper = 0);
  bool take_frames();
  /// @return whether all of them have run: not when the service ends.
  bool run_ticks(std::uint64_t ticks, const std::atomic<bool>& stop);
  [[nodiscard]] bool may_publish();
  void publish_status(bool repeated = false);
  void idle();

  // steppers: lockstep_steppers.cpp
  void join(const Arrival& arrival);
  void leave(const Arrival& arrival);
  void part_with(std::uint64_t session, Parting parting);
  void put_aside(Arrival& arrival);
  void advance(const std::atomic<bool>& stop);
  void grant_arrived(Clock::time_point now);
  [[nodiscard]] std::uint64_t ticks_to_go() const;
  void answer_due(Clock::time_point now);
  [[nodiscard]] bool answer_if_due(const WaitingStep& waiting, Clock::time_point now);
  void remove_absent(Clock::time_point now);
  void refuse_waiting();
  void show_steppers();

  BenchEngine& engine_;
  Inbox& inbox_;
  Outbox& outbox_;
  StatusPublisher& status_;
  ReplyPublisher& replies_;
  Counters& counters_;
  std::uint32_t status_every_;
  std::deque<Arrival> deferred_;  ///< requests that came while a step waited for its commands
  StepperTable steppers_;
  std::deque<WaitingStep> waiting_;
  std::vector<std::uint64_t> stepping_;  ///< sessions that step the present ticks
  Clock::time_point next_check_{};
  Counter beats_;
  TokenBucket shown_ticks_{kStatusRate};
};

}  // namespace vdrive::service
