// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "board.hpp"
#include "drops.hpp"
#include "inbox.hpp"
#include "ros_time.hpp"
#include "served_benches.hpp"
#include "settings.hpp"
#include "trajectories.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <cstddef>
#include <functional>
#include <thread>

namespace vdrive::ros2 {

/// Commands the benches: takes the messages of ROS, in a thread of its own that never waits for a
/// bench.
class Controller {
 public:
  /// What it asks the participant of ROS.
  struct Questions {
    /// The number of nodes that write joint commands now. When the last one ends, joints that
    /// velocity or effort move brake.
    std::function<std::size_t()> writers{};
    std::function<wire::GuardCounts()> guard_counts{};  ///< what the guard refused until now
  };

  /// @param session outlives the controller, as the others do
  /// @param inbox gives it the messages
  Controller(client::Session& session, const Settings& settings, bridge::Reports& reports,
             Inbox& inbox, Board& board, Questions questions);

  /// Disables the axes that it has enabled, as far as that is possible within two seconds.
  ~Controller();
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] ServedBenches::Calls calls_to(client::Session& session);
  void run(const std::stop_token& stop);
  void turn();
  void end();
  void handle_messages();
  void handle(const ros::JointState& message, const wire::WriterId& writer);
  void handle(const ros::JointTrajectory& message, const wire::WriterId& writer);
  void handle(const ros::Bool& message, const wire::WriterId& writer);
  void ask(Clock::time_point now);
  void note_writers(std::size_t writers);
  void update(Clock::time_point now);

  bridge::Reports& reports_;
  Inbox& inbox_;
  Board& board_;
  const Questions questions_;
  ServedBenches benches_;
  Trajectories trajectories_;
  StampOrder command_stamps_;
  Drops drops_;
  bool had_writers_ = false;
  std::jthread thread_;
};

}  // namespace vdrive::ros2
