// SPDX-License-Identifier: Apache-2.0
#include "ros_time.hpp"

#include "wall_time.hpp"

#include <chrono>
#include <cstdlib>

namespace vdrive::ros2 {

std::int64_t stamp_of(const client::BenchInfo& bench, std::uint64_t tick) {
  const std::int64_t drive_time =
      static_cast<std::int64_t>(tick) * std::chrono::nanoseconds(bench.period).count();
  if (bench.clock_mode != client::ClockMode::realtime) return drive_time;
  // Nodes of ROS on this machine compare stamps with the time of day. A bench whose ticks were
  // scaled or paused has another time: its stamps would look old, and transforms be dropped.
  const std::int64_t now = bridge::wall_time();
  return std::abs(now - drive_time) < kNanosecondsPerSecond ? drive_time : now;
}

}  // namespace vdrive::ros2
