// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ros_messages.hpp"

#include <string>
#include <string_view>

/// The ROS 2 types that vdrive uses; see idl/ros_messages.idl.
namespace vdrive::ros {

using Time = builtin_interfaces::msg::dds_::Time_;
using Duration = builtin_interfaces::msg::dds_::Duration_;
using Header = std_msgs::msg::dds_::Header_;
using Bool = std_msgs::msg::dds_::Bool_;
using JointState = sensor_msgs::msg::dds_::JointState_;
using JointTrajectoryPoint = trajectory_msgs::msg::dds_::JointTrajectoryPoint_;
using JointTrajectory = trajectory_msgs::msg::dds_::JointTrajectory_;
using KeyValue = diagnostic_msgs::msg::dds_::KeyValue_;
using DiagnosticStatus = diagnostic_msgs::msg::dds_::DiagnosticStatus_;
using DiagnosticArray = diagnostic_msgs::msg::dds_::DiagnosticArray_;
using Clock = rosgraph_msgs::msg::dds_::Clock_;
using Log = rcl_interfaces::msg::dds_::Log_;

/// Returns the canonical description of a type, from which its hash is computed (REP 2016): JSON
/// with the members in order and, by name, the descriptions of the types that it uses.
/// @param type such as "sensor_msgs/msg/JointState"
/// @throws std::invalid_argument for a type that vdrive does not use
[[nodiscard]] std::string type_description(std::string_view type);

/// Returns the hash of a type as ROS 2 announces it: "RIHS01_" and 64 hexadecimal digits.
/// @throws std::invalid_argument as type_description() does
[[nodiscard]] std::string type_hash(std::string_view type);

}  // namespace vdrive::ros
