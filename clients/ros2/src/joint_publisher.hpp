// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "board.hpp"
#include "settings.hpp"
#include "state_times.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

namespace vdrive::ros2 {

/// @return the joints of a bench in one instant, or nothing while its bench sends no status.
[[nodiscard]] std::optional<ros::JointState> joint_state_of(const BenchView& view);

/// Publishes joint states, clock and diagnostics in a thread of its own. The clock comes with the
/// states; diagnostics come once a second and when a level or a message changes.
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
