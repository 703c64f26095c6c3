// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "controller.hpp"
#include "inbox.hpp"
#include "joint_publisher.hpp"

namespace vdrive::ros2 {

/// The complete bridge: one session for the benches, one participant for ROS.
class Bridge {
 public:
  /// @throws std::runtime_error if DDS cannot be set up.
  explicit Bridge(const Settings& settings);
  ~Bridge();
  Bridge(const Bridge&) = delete;
  Bridge& operator=(const Bridge&) = delete;

  /// @return the number of its session, shown as the owner of axes.
  [[nodiscard]] std::uint64_t session() const noexcept { return session_.id(); }

  /// Reports a message from the log of the DDS library. For any thread except those that receive.
  void report_library(const std::string& words);

 private:
  void write_log(bridge::Severity severity, const std::string& line);

  std::unique_ptr<wire::Participant> participant_;
  client::Session session_;
  ros::Publication<ros::Log> rosout_;
  bridge::Reports reports_;
  Inbox inbox_;
  Board board_;
  ros::Subscription<ros::JointState> commands_;
  ros::Subscription<ros::JointTrajectory> trajectories_;
  ros::Subscription<ros::Bool> enable_;
  // After everything that it uses: it disables the axes when it is destroyed.
  Controller controller_;
  JointPublisher publisher_;
};

}  // namespace vdrive::ros2
