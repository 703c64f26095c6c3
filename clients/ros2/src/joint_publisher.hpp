// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "board.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <map>
#include <thread>

namespace vdrive::ros2 {

/// @return the joints of a bench in one instant, or nothing while its bench sends no status.
[[nodiscard]] std::optional<ros::JointState> joint_state_of(const BenchView& view);

/// @return a status for each bench and each of its joints.
/// @param network "loopback only", or the addresses that the bridge uses
[[nodiscard]] ros::DiagnosticArray diagnostics_of(const Board::Views& views,
                                                  const std::string& network);

/// Publishes joint states, clock and diagnostics in a thread of its own.
///
/// In lock-step a state is published after each period of drive time and where a step ends; the
/// clock with it. Diagnostics come once a second and when a level or a message changes.
class JointPublisher {
 public:
  JointPublisher(wire::Participant& participant, const Settings& settings, Board& board);

 private:
  using Clock = std::chrono::steady_clock;

  /// What was published of a bench.
  struct Published {
    std::uint64_t incarnation = 0;
    std::uint64_t tick = 0;
    Clock::time_point due{};
    std::uint64_t waiting = 0;  ///< tick that was not published at once
    Clock::time_point waiting_since{};
  };

  void run(const std::stop_token& stop);
  void publish(const Board::Views& views, Clock::time_point now);
  [[nodiscard]] bool is_due(const BenchView& view, Published& published,
                            Clock::time_point now) const;
  void publish_diagnostics(const Board::Views& views, Clock::time_point now);

  const double rate_;
  const std::string network_;
  Board& board_;
  std::map<std::uint32_t, Published> published_;
  Clock::time_point diagnostics_due_{};
  std::string last_diagnostics_;
  ros::Publication<ros::JointState> states_;
  ros::Publication<ros::Clock> clock_;
  ros::Publication<ros::DiagnosticArray> diagnostics_;
  std::jthread thread_;
};

}  // namespace vdrive::ros2
