// SPDX-License-Identifier: Apache-2.0
#include "ros2/ros_peer.hpp"

#include "support/deadline.hpp"
#include "support/test_domain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 30s;
constexpr std::int64_t kSecond = 1'000'000'000;

std::vector<std::string> arguments_of(const std::string& words) {
  std::vector<std::string> arguments{"--domain", std::to_string(test_domain())};
  std::istringstream stream(words);
  for (std::string word; stream >> word;) arguments.push_back(word);
  return arguments;
}

std::int64_t nanoseconds(const ros::Time& time) {
  return time.sec * kSecond + time.nanosec;
}

}  // namespace

RunningBridge::RunningBridge(const std::string& words)
    : process_(VDRIVE_ROS2, arguments_of(words)) {
  if (!process_.read_line().starts_with("vdrive-ros2: /")) {
    throw std::runtime_error("vdrive-ros2 did not start");
  }
}

RunningBridge::~RunningBridge() {
  if (has_ended_) return;
  const Finished finished = stop();
  EXPECT_EQ(finished.code, 0) << finished.errors;
}

Finished RunningBridge::stop() {
  has_ended_ = true;
  process_.send(SIGTERM);
  return process_.wait();
}

void RunningBridge::pause() {
  process_.send(SIGSTOP);
}

void RunningBridge::go_on() {
  process_.send(SIGCONT);
}

void RunningBridge::kill() {
  has_ended_ = true;
  process_.send(SIGKILL);
  (void)process_.wait();
}

RosPeer::RosPeer(const std::string& name_space)
    : participant_(wire::make_participant({.domain = test_domain()}, "ros node of a test")),
      commands_(std::in_place, *participant_, name_space + "/robot_joint_commands"),
      trajectories_(*participant_, name_space + "/joint_trajectory"),
      enable_(*participant_, name_space + "/enable"),
      state_reader_(*participant_, name_space + "/joint_states",
                    [this](const ros::JointState& message, const wire::WriterId& /*writer*/) {
                      take([&] {
                        ++count_;
                        for (ros::JointState& known : states_) {
                          if (known.name != message.name) continue;
                          known = message;
                          return;
                        }
                        states_.push_back(message);
                      });
                    }),
      diagnostics_reader_(
          *participant_, "/diagnostics",
          [this](const ros::DiagnosticArray& message, const wire::WriterId& /*writer*/) {
            take([&] {
              diagnostics_ = message;
            });
          }),
      log_reader_(*participant_, "/rosout",
                  [this](const ros::Log& message, const wire::WriterId& /*writer*/) {
                    take([&] {
                      log_ += message.msg + "\n";
                    });
                  }),
      clock_reader_(*participant_, "/clock",
                    [this](const ros::Clock& message, const wire::WriterId& /*writer*/) {
                      take([&] {
                        clock_ = nanoseconds(message.clock);
                      });
                    }) {}

bool RosPeer::wait_for_bridge() {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  std::unique_lock lock(mutex_);
  while (std::chrono::steady_clock::now() < deadline) {
    const bool is_matched = commands_->matched() > 0 && trajectories_.matched() > 0 &&
                            enable_.matched() > 0 && log_reader_.matched() > 0;
    if (is_matched && !states_.empty()) return true;
    changed_.wait_for(lock, 20ms);
  }
  report_missed_deadline("no bridge was found", kPatience);
  std::cerr << "it reads " << commands_->matched() << " " << trajectories_.matched() << " "
            << enable_.matched() << " of ours, we read " << log_reader_.matched() << " "
            << state_reader_.matched() << " of its topics and " << states_.size() << " states\n";
  return false;
}

void RosPeer::command(const std::vector<std::string>& names, const std::vector<double>& positions) {
  ros::JointState message;
  message.name = names;
  message.position = positions;
  command(message);
}

void RosPeer::command_velocity(const std::vector<std::string>& names,
                               const std::vector<double>& velocities) {
  ros::JointState message;
  message.name = names;
  message.velocity = velocities;
  command(message);
}

void RosPeer::command_effort(const std::vector<std::string>& names,
                             const std::vector<double>& efforts) {
  ros::JointState message;
  message.name = names;
  message.effort = efforts;
  command(message);
}

void RosPeer::enable(bool value) {
  ros::Bool message;
  message.data = value;
  (void)enable_.write(message);
}

std::optional<ros::JointState> RosPeer::state(const std::string& joint) const {
  const std::scoped_lock lock(mutex_);
  for (const ros::JointState& known : states_) {
    if (std::ranges::count(known.name, joint) > 0) return known;
  }
  return std::nullopt;
}

std::optional<double> RosPeer::value(const std::string& joint,
                                     std::vector<double> ros::JointState::*member) const {
  const auto newest = state(joint);
  if (!newest) return std::nullopt;
  const auto place = std::ranges::find(newest->name, joint) - newest->name.begin();
  return ((*newest).*member).at(static_cast<std::size_t>(place));
}

std::optional<double> RosPeer::position(const std::string& joint) const {
  return value(joint, &ros::JointState::position);
}

std::optional<double> RosPeer::velocity(const std::string& joint) const {
  return value(joint, &ros::JointState::velocity);
}

std::string RosPeer::diagnosis(const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  for (const ros::DiagnosticStatus& status : diagnostics_.status) {
    if (status.name == "vdrive_ros2: " + name) {
      return std::to_string(std::to_integer<int>(status.level)) + " " + status.message;
    }
  }
  return {};
}

std::string RosPeer::log() const {
  const std::scoped_lock lock(mutex_);
  return log_;
}

std::int64_t RosPeer::clock() const {
  const std::scoped_lock lock(mutex_);
  return clock_;
}

std::size_t RosPeer::states() const {
  const std::scoped_lock lock(mutex_);
  return count_;
}

bool RosPeer::wait(const std::function<bool()>& condition) const {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    if (condition()) return true;
    if (std::chrono::steady_clock::now() >= deadline) {
      report_missed_deadline("the condition did not hold", kPatience);
      return false;
    }
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, 20ms);
  }
}

bool RosPeer::wait_for_stamp(const std::string& joint, std::int64_t time) const {
  return wait([&] {
    const auto newest = state(joint);
    return newest && nanoseconds(newest->header.stamp) >= time;
  });
}

bool RosPeer::wait_for_log(const std::string& text) const {
  return wait([&] {
    return log().find(text) != std::string::npos;
  });
}

}  // namespace vdrive::test
