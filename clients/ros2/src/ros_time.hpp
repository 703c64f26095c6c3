// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/bench.hpp"
#include "vdrive/wire/ros_types.hpp"
#include "vdrive/wire/writer_id.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

/// Times as used by ROS [ns].
namespace vdrive::ros2 {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
inline constexpr double kSecondsPerNanosecond = 1e-9;

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
///         the time of day by 1 s or more, the time of day.
[[nodiscard]] std::int64_t stamp_of(const client::BenchInfo& bench, std::uint64_t tick);

/// Checks the stamps of messages: those of one writer must not go back, and none may be far ahead
/// of the time of its bench. A wrong stamp of one writer does not affect another.
class StampOrder {
 public:
  /// Most writers known at the same time; beyond that, all are forgotten.
  static constexpr std::size_t kMostWriters = 1024;

  /// @param most_ahead of the time of a bench [s]; 0 = unlimited
  explicit StampOrder(double most_ahead) : most_ahead_(most_ahead) {}

  /// @param stamp [ns]; 0 = none, which is always valid
  /// @param now the time of the bench [ns]; nothing while it sends no status
  /// @return the error in the stamp, such as "its stamp is 2 s earlier than the previous one";
  ///         empty if it is valid.
  [[nodiscard]] std::string problem(const wire::WriterId& writer, std::int64_t stamp,
                                    std::optional<std::int64_t> now) const;

  /// Records that the message with this stamp was accepted.
  void note(const wire::WriterId& writer, std::int64_t stamp);

  /// Treats the next message of each writer as its first.
  void clear() noexcept { last_.clear(); }

 private:
  double most_ahead_;
  std::map<wire::WriterId, std::int64_t> last_;  ///< stamp of each writer
};

}  // namespace vdrive::ros2
