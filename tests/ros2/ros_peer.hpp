// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tool/process.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::test {

/// A running vdrive-ros2 of this build, on the domain of this test.
class RunningBridge {
 public:
  /// @param words command line without the domain
  explicit RunningBridge(const std::string& words = "");

  ~RunningBridge();  ///< stops it, unless stop() or kill() did; expects exit code 0
  RunningBridge(const RunningBridge&) = delete;
  RunningBridge& operator=(const RunningBridge&) = delete;

  /// Ends it as a user would, with SIGTERM.
  Finished stop();

  /// Kills it, so that it cannot release its axes.
  void kill();

  /// Pause and resume its process.
  void pause();
  void go_on();

 private:
  Process process_;
  bool has_ended_ = false;
};

/// A ROS node that reads the topics of the bridge and sends it commands.
class RosPeer {
 public:
  explicit RosPeer(const std::string& name_space = "");

  /// Waits until the bridge and this node read each other's topics.
  /// @return false after 20 s.
  [[nodiscard]] bool wait_for_bridge();

  void command(ros::JointState message) { (void)commands_->write(message); }

  void command(const std::vector<std::string>& names, const std::vector<double>& positions);
  void command_velocity(const std::vector<std::string>& names,
                        const std::vector<double>& velocities);
  void command_effort(const std::vector<std::string>& names, const std::vector<double>& efforts);

  void start(const ros::JointTrajectory& trajectory) { (void)trajectories_.write(trajectory); }

  void enable(bool value);

  /// Stops writing joint commands: deletes the writer.
  void stop_commanding() { commands_.reset(); }

  /// @return the latest state of the bench with this joint.
  [[nodiscard]] std::optional<ros::JointState> state(const std::string& joint) const;

  /// @return the latest position, if any.
  [[nodiscard]] std::optional<double> position(const std::string& joint) const;
  [[nodiscard]] std::optional<double> velocity(const std::string& joint) const;

  /// @return level and message of the latest diagnostics about this name.
  [[nodiscard]] std::string diagnosis(const std::string& name) const;

  /// @return all lines of rosout so far, each with a line feed.
  [[nodiscard]] std::string log() const;

  /// @return the latest time of /clock [ns]; 0 before the first message.
  [[nodiscard]] std::int64_t clock() const;

  /// Waits until the condition holds, checking it after each message.
  /// @return false after 30 s.
  [[nodiscard]] bool wait(const std::function<bool()>& condition) const;

  /// Waits for a state of the bench with this joint whose stamp is this time or later.
  [[nodiscard]] bool wait_for_stamp(const std::string& joint, std::int64_t nanoseconds) const;

  [[nodiscard]] bool wait_for_log(const std::string& text) const;

  /// @return the number of joint state messages so far.
  [[nodiscard]] std::size_t states() const;

 private:
  template <typename Store>
  void take(const Store& store) {
    const std::scoped_lock lock(mutex_);
    store();
    changed_.notify_all();
  }

  [[nodiscard]] std::optional<double> value(const std::string& joint,
                                            std::vector<double> ros::JointState::*member) const;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::vector<ros::JointState> states_;  ///< the latest of each bench
  std::size_t count_ = 0;
  ros::DiagnosticArray diagnostics_;
  std::string log_;
  std::int64_t clock_ = 0;
  std::unique_ptr<wire::Participant> participant_;
  std::optional<ros::Publication<ros::JointState>> commands_;
  ros::Publication<ros::JointTrajectory> trajectories_;
  ros::Publication<ros::Bool> enable_;
  ros::Subscription<ros::JointState> state_reader_;
  ros::Subscription<ros::DiagnosticArray> diagnostics_reader_;
  ros::Subscription<ros::Log> log_reader_;
  ros::Subscription<ros::Clock> clock_reader_;
};

}  // namespace vdrive::test
