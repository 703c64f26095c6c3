// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "board.hpp"
#include "settings.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

namespace vdrive::ros2 {

/// Schedules the publication of joint states. In lock-step a state is published after each period
/// of drive time and at the end of a step, otherwise at the rate in wall time. While no tick
/// passes, the state is repeated once per second. Time is passed as an argument.
class StateTimes {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param rate states per second
  explicit StateTimes(double rate)
      : rate_(rate),
        period_(std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(1.0 / rate))) {}

  /// @param tick of the newest state of the bench
  /// @return whether that state is due; then it counts as published.
  [[nodiscard]] bool take(const client::BenchInfo& bench, std::uint64_t tick,
                          Clock::time_point now);

  /// @return when to call take() again, unless a new state arrives earlier.
  [[nodiscard]] Clock::time_point next(Clock::time_point now) const;

 private:
  /// The publications of a bench.
  struct Published {
    std::uint64_t incarnation = 0;
    std::uint64_t tick = 0;
    Clock::time_point taken{};  ///< when it was published
    Clock::time_point due{};
    std::uint64_t waiting = 0;  ///< tick that was not published immediately
    Clock::time_point waiting_since{};
  };

  [[nodiscard]] bool is_due(Published& published, const client::BenchInfo& bench,
                            std::uint64_t tick, Clock::time_point now) const;
  [[nodiscard]] bool is_due_at_rate(Published& published, Clock::time_point now) const;
  [[nodiscard]] bool is_due_in_lockstep(Published& published, const client::BenchInfo& bench,
                                        std::uint64_t tick, Clock::time_point now) const;

  const double rate_;
  const Clock::duration period_;
  std::map<std::uint32_t, Published> published_;
};

/// @return the joints of a bench at one instant, or nothing while the bench sends no status.
[[nodiscard]] std::optional<ros::JointState> joint_state_of(const BenchView& view);

/// Publishes joint states, clock and diagnostics on a separate thread. The clock is published with
/// the states; diagnostics once per second and when a level or a message changes.
class JointPublisher {
 public:
  JointPublisher(wire::Participant& participant, const Settings& settings, Board& board);

 private:
  using Clock = std::chrono::steady_clock;

  void run(const std::stop_token& stop);
  void publish(const Board::Views& views, Clock::time_point now);
  void publish_diagnostics(const Board::Views& views, Clock::time_point now);

  const std::string network_;
  Board& board_;
  StateTimes times_;
  Clock::time_point diagnostics_due_{};
  std::string last_levels_;
  ros::Publication<ros::JointState> states_;
  ros::Publication<ros::Clock> clock_;
  ros::Publication<ros::DiagnosticArray> diagnostics_;
  std::jthread thread_;
};

}  // namespace vdrive::ros2
