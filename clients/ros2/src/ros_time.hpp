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

/// Judges the stamps of messages: those of one writer do not go back, and none is far ahead of the
/// time of its bench. A wrong stamp of one writer does not concern another one.
class StampOrder {
 public:
  /// How many writers are known at once; when there are more all are forgotten.
  static constexpr std::size_t kMostWriters = 1024;

  /// @param most_ahead of the time of a bench [s]; 0 = without a limit
  explicit StampOrder(double most_ahead) : most_ahead_(most_ahead) {}

  /// @param stamp [ns]; 0 = none, which is always good
  /// @param now the time of the bench [ns]; none while it sends no status
  /// @return what is wrong with the stamp, such as "its stamp is 2 s earlier than that of the one
  ///         before"; empty for a good one.
  [[nodiscard]] std::string problem(const wire::WriterId& writer, std::int64_t stamp,
                                    std::optional<std::int64_t> now) const;

  /// The message with this stamp was accepted.
  void note(const wire::WriterId& writer, std::int64_t stamp);

  /// What comes next is the first of its writer.
  void clear() noexcept { last_.clear(); }

 private:
  double most_ahead_;
  std::map<wire::WriterId, std::int64_t> last_;  ///< stamp of each writer
};

}  // namespace vdrive::ros2
