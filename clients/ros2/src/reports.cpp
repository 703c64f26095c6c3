// SPDX-License-Identifier: Apache-2.0
#include "reports.hpp"

#include "vdrive/text.hpp"

#include <chrono>
#include <iostream>

namespace vdrive::ros2 {
namespace {

constexpr std::size_t kMostSubjects = 1024;
constexpr std::size_t kMostTexts = 64;
constexpr std::chrono::seconds kAgain{1};
constexpr std::size_t kLongestText = 1000;
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

const char* word_of(Severity severity) {
  if (severity == Severity::info) return "";
  return severity == Severity::warning ? "warning: " : "error: ";
}

}  // namespace

Reports::Reports(wire::Participant& participant, const std::string& topic)
    : rosout_(participant, topic) {}

bool Reports::is_due(Subject& subject, const std::string& text) {
  const auto now = Clock::now();
  if (subject.texts.size() > kMostTexts) subject.texts.clear();
  const auto [reported, is_new] = subject.texts.try_emplace(text, now);
  subject.limit.refill(now.time_since_epoch());
  if ((!is_new && now - reported->second < kAgain) || !subject.limit.take()) return false;
  reported->second = now;
  return true;
}

void Reports::report(Severity severity, const std::string& subject, const std::string& text) {
  const std::scoped_lock lock(mutex_);
  if (subjects_.size() > kMostSubjects) subjects_.clear();
  Subject& known = subjects_[subject];
  if (!is_due(known, text)) {
    ++known.left_out;
    return;
  }
  std::string line = escaped(subject + ": " + text, kLongestText);
  if (known.left_out > 0) line += " (" + std::to_string(known.left_out) + " more before)";
  known.left_out = 0;
  std::cerr << "vdrive-ros2: " << word_of(severity) << line << std::endl;
  wire::ros::Log log;
  log.stamp(ros_time(wall_time()));
  log.level(static_cast<std::uint8_t>(severity));
  log.name("vdrive_ros2");
  log.msg(line);
  (void)rosout_.write(log);
}

wire::ros::Time ros_time(std::int64_t nanoseconds) {
  wire::ros::Time time;
  time.sec(static_cast<std::int32_t>(nanoseconds / kNanosecondsPerSecond));
  time.nanosec(static_cast<std::uint32_t>(nanoseconds % kNanosecondsPerSecond));
  return time;
}

std::int64_t wall_time() {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace vdrive::ros2
