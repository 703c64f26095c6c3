// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rate_limit.hpp"
#include "vdrive/wire/ros.hpp"

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace vdrive::ros2 {

/// How much it matters; the numbers are those of rcl_interfaces/msg/Log.
enum class Severity : std::uint8_t { info = 20, warning = 30, error = 40 };

/// Tells people what happens: a line on standard error and a message on rosout. What comes again
/// and again is told once a second, and of a subject no more than five texts a second, with the
/// number of those left out. Thread-safe; not for DDS threads.
class Reports {
 public:
  Reports(wire::Participant& participant, const std::string& topic);

  /// @param subject what the report is about; reports of one subject are limited together
  /// @param text a sentence without a full stop
  void tell(Severity severity, const std::string& subject, const std::string& text);

 private:
  /// Whether a text about a subject may be told, and what was left out before.
  struct Subject {
    bridge::RateLimit limit{5.0, 10.0};
    std::map<std::string, bridge::RateLimit::Clock::time_point> texts{};  ///< when they were told
    std::uint64_t left_out = 0;
  };

  [[nodiscard]] static bool may_tell(Subject& subject, const std::string& text);

  std::mutex mutex_;
  std::map<std::string, Subject> subjects_;
  wire::ros::Publication<wire::ros::Log> rosout_;
};

/// @return `nanoseconds` as ROS writes it.
[[nodiscard]] wire::ros::Time ros_time(std::int64_t nanoseconds);

/// @return [ns] since 1970
[[nodiscard]] std::int64_t wall_time();

}  // namespace vdrive::ros2
