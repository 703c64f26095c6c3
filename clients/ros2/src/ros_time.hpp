// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"
#include "vdrive/wire/ros_types.hpp"

#include <cstdint>

/// Times as ROS has them [ns].
namespace vdrive::ros2 {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
inline constexpr double kSecondsPerNanosecond = 1e-9;

/// @return `nanoseconds` as ROS writes it.
[[nodiscard]] inline ros::Time ros_time(std::int64_t nanoseconds) {
  ros::Time time;
  time.sec = static_cast<std::int32_t>(nanoseconds / kNanosecondsPerSecond);
  time.nanosec = static_cast<std::uint32_t>(nanoseconds % kNanosecondsPerSecond);
  return time;
}

[[nodiscard]] inline std::int64_t nanoseconds_of(const ros::Time& time) noexcept {
  return time.sec * kNanosecondsPerSecond + time.nanosec;
}

/// @return the time of a tick: drive time; for a bench in realtime whose drive time differs from
///         the time of day, the time of day.
[[nodiscard]] std::int64_t stamp_of(const client::BenchInfo& bench, std::uint64_t tick);

}  // namespace vdrive::ros2
