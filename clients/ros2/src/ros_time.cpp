// SPDX-License-Identifier: Apache-2.0
#include "ros_time.hpp"

#include "joint_limits.hpp"
#include "wall_time.hpp"

#include <chrono>
#include <cstdlib>

namespace vdrive::ros2 {
namespace {

/// @return the time from `begin` to `end` [s].
double seconds_between(std::int64_t begin, std::int64_t end) noexcept {
  return static_cast<double>(end - begin) / kNanosecondsPerSecond;
}

}  // namespace

std::int64_t stamp_of(const client::BenchInfo& bench, std::uint64_t tick) {
  const std::int64_t drive_time =
      static_cast<std::int64_t>(tick) * std::chrono::nanoseconds(bench.period).count();
  if (bench.clock_mode != client::ClockMode::realtime) return drive_time;
  // ROS nodes on this machine compare stamps with the time of day. The time of a bench that was
  // scaled or paused differs from that: its stamps would look old, and transforms would be dropped.
  const std::int64_t now = bridge::wall_time();
  return std::abs(now - drive_time) < kNanosecondsPerSecond ? drive_time : now;
}

std::string StampOrder::problem(const wire::WriterId& writer, std::int64_t stamp,
                                std::optional<std::int64_t> now) const {
  if (stamp == 0) return {};
  const auto last = last_.find(writer);
  if (last != last_.end() && stamp < last->second) {
    return "its stamp is " + text_of(seconds_between(stamp, last->second)) +
           " s earlier than the previous one";
  }
  if (!now || most_ahead_ == 0.0 || seconds_between(*now, stamp) <= most_ahead_) return {};
  return "its stamp is " + text_of(seconds_between(*now, stamp)) +
         " s ahead of the time of its bench, more than the stamp_ahead of " + text_of(most_ahead_) +
         " s";
}

void StampOrder::note(const wire::WriterId& writer, std::int64_t stamp) {
  if (stamp == 0) return;
  // Writers come and go with new numbers. If all are forgotten, one stamp of each is not compared.
  if (last_.size() >= kMostWriters && !last_.contains(writer)) last_.clear();
  last_[writer] = stamp;
}

}  // namespace vdrive::ros2
