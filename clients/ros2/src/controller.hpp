// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "board.hpp"
#include "drops.hpp"
#include "inbox.hpp"
#include "ros_time.hpp"
#include "served_benches.hpp"
#include "settings.hpp"
#include "trajectories.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

namespace vdrive::ros2 {

/// Commands the benches: processes ROS messages on a separate thread that never waits for a bench.
class Controller final : private BenchAccess {
 public:
  /// @param session must outlive the controller, like the others
  /// @param inbox source of the messages
  /// @param commands the subscription to commands: when the last node that writes them ends, joints
  ///        moved by velocity or effort brake
  /// @param participant of ROS; its guard counts the datagrams that it refuses
  Controller(client::Session& session, const Settings& settings, bridge::Reports& reports,
             Inbox& inbox, Board& board, const ros::Subscription<ros::JointState>& commands,
             const wire::Participant& participant);

  /// Disables the axes that it has enabled, as far as possible within two seconds.
  ~Controller() override;
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

 private:
  using Clock = std::chrono::steady_clock;

  std::vector<client::BenchInfo> present_benches() override;
  std::unique_ptr<FollowedBench> connect(Bench& bench) override;
  client::Outcome send_set_points(std::uint32_t bench,
                                  const SetPointStream::Frames& frames) override;
  void end_run(BenchMotion& motion) override;
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

  client::Session& session_;
  bridge::Reports& reports_;
  Inbox& inbox_;
  Board& board_;
  const ros::Subscription<ros::JointState>& commands_;
  const wire::Participant& participant_;
  ServedBenches benches_;
  Trajectories trajectories_;
  StampOrder command_stamps_;
  Drops drops_;
  bool had_writers_ = false;
  std::jthread thread_;
};

}  // namespace vdrive::ros2
