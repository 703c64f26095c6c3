// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/ros.hpp"

#include <cstdint>

namespace vdrive::ros2 {

/// @return `nanoseconds` as ROS writes it.
[[nodiscard]] inline ros::Time ros_time(std::int64_t nanoseconds) {
  constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
  ros::Time time;
  time.sec(static_cast<std::int32_t>(nanoseconds / kNanosecondsPerSecond));
  time.nanosec(static_cast<std::uint32_t>(nanoseconds % kNanosecondsPerSecond));
  return time;
}

}  // namespace vdrive::ros2
