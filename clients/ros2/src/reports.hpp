// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/token_bucket.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace vdrive::ros2 {

/// The level of a report; the numbers are those of rcl_interfaces/msg/Log.
enum class Severity : std::uint8_t { info = 20, warning = 30, error = 40 };

/// Reports to people: a line on standard error and a message on rosout. An equal text is reported
/// once a second, and of a subject no more than five texts a second, with the number of those left
/// out. Thread-safe; not for DDS threads.
class Reports {
 public:
  Reports(wire::Participant& participant, const std::string& topic);

  /// @param subject what the report is about; reports of one subject are limited together
  /// @param text a sentence without a full stop
  void report(Severity severity, const std::string& subject, const std::string& text);

 private:
  using Clock = std::chrono::steady_clock;

  /// What was reported about a subject, and how many texts were left out since.
  struct Subject {
    TokenBucket limit{{.per_second = 5.0, .burst = 10.0}};
    std::map<std::string, Clock::time_point> texts{};  ///< when they were reported
    std::uint64_t left_out = 0;
  };

  [[nodiscard]] static bool is_due(Subject& subject, const std::string& text);

  std::mutex mutex_;
  std::map<std::string, Subject> subjects_;
  wire::ros::Publication<wire::ros::Log> rosout_;
};

/// @return `nanoseconds` as ROS writes it.
[[nodiscard]] wire::ros::Time ros_time(std::int64_t nanoseconds);

/// @return [ns] since 1970
[[nodiscard]] std::int64_t wall_time();

}  // namespace vdrive::ros2
