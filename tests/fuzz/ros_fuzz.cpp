// SPDX-License-Identifier: Apache-2.0
//
// Any bytes on the topics that command vdrive-ros2 are a message or are dropped. Any message is
// processed: its commands have finite values, its trajectory keeps the limits against which it was
// checked, and positions that arrive irregularly are followed without a jump.
#include "fuzz/support/bytes.hpp"
#include "joint_path.hpp"
#include "joint_tracker.hpp"
#include "requests.hpp"
#include "ros_messages_description.hpp"
#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/ros_types.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace vdrive::ros2;
using vdrive::test::Bytes;
using vdrive::test::demand;
namespace ros = vdrive::ros;
namespace wire = vdrive::wire;

constexpr std::size_t kJoints = 4;

/// Joints a, b, c and d; the configuration assigns d to velocities.
std::optional<JointPlace> find_joint(const std::string& name, std::string& problem) {
  if (name.size() != 1 || name < "a" || name > "d") {
    problem = "is unknown";
    return std::nullopt;
  }
  JointPlace joint{.bench = 1, .place = static_cast<std::size_t>(name[0] - 'a')};
  if (name == "d") joint.interface = CommandInterface::velocity;
  return joint;
}

JointLimits limits() {
  return {.lower = -10.0,
          .upper = 10.0,
          .velocity = 5.0,
          .acceleration = 50.0,
          .deceleration = 40.0,
          .ramp = 30.0,
          .effort = 3.0};
}

void check_sentence(const std::string& text) {
  demand(!text.empty() && text.size() < 2'000, "a problem is a sentence");
  demand(text.find('\n') == std::string::npos, "on one line");
}

// ---- messages --------------------------------------------------------------------------------

template <typename Message>
bool decode(std::span<const std::uint8_t> data, Message& message) {
  wire::CdrReader reader(std::as_bytes(data));
  reader.get(message);
  return reader.is_good();
}

/// @return small numbers most of the time, sometimes any double or a value on which a calculation
///         may fail.
double take_double(Bytes& bytes) {
  constexpr std::array kSpecial{0.0,
                                -0.0,
                                std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::max(),
                                std::numeric_limits<double>::denorm_min(),
                                1e300,
                                -1e155};
  constexpr double kStep = 1.0 / 4096.0;
  switch (bytes.below(8)) {
    case 0:
      return kSpecial[bytes.below(kSpecial.size())];
    case 1:
      return std::bit_cast<double>(bytes.take<std::uint64_t>());
    default:
      return bytes.take<std::int16_t>() * kStep;
  }
}

std::vector<double> take_array(Bytes& bytes, std::size_t usual) {
  const std::size_t choice = bytes.below(16);
  std::vector<double> values(choice == 0 ? bytes.below(6) : choice < 5 ? 0 : usual);
  for (double& value : values) value = take_double(bytes);
  return values;
}

std::vector<std::string> take_names(Bytes& bytes) {
  std::vector<std::string> names(1 + bytes.below(kJoints));
  std::size_t next = bytes.below(kJoints);
  for (std::string& name : names) {
    name = std::string(1, static_cast<char>('a' + next));
    if (bytes.below(16) == 0) name = static_cast<char>(bytes.take());
    next = (next + 1) % kJoints;
  }
  return names;
}

ros::JointState take_state(Bytes& bytes) {
  ros::JointState message;
  message.name = take_names(bytes);
  message.position = take_array(bytes, message.name.size());
  message.velocity = take_array(bytes, message.name.size());
  message.effort = take_array(bytes, message.name.size());
  return message;
}

ros::JointTrajectory take_trajectory(Bytes& bytes) {
  constexpr std::size_t kMostPoints = 6;
  ros::JointTrajectory message;
  message.joint_names = take_names(bytes);
  const std::size_t joints = message.joint_names.size();
  const std::size_t points = 1 + bytes.below(kMostPoints);
  std::int32_t seconds = 0;
  for (std::size_t i = 0; i < points; ++i) {
    ros::JointTrajectoryPoint point;
    point.positions = take_array(bytes, joints);
    point.velocities = take_array(bytes, joints);
    point.accelerations = take_array(bytes, joints);
    const bool is_any = bytes.below(16) == 0;
    seconds = is_any ? bytes.take<std::int32_t>()
                     : static_cast<std::int32_t>(static_cast<std::uint32_t>(seconds) +
                                                 static_cast<std::uint32_t>(bytes.below(3)));
    point.time_from_start.sec = seconds;
    point.time_from_start.nanosec = bytes.take<std::uint32_t>();
    message.points.push_back(std::move(point));
  }
  return message;
}

// ---- their effects --------------------------------------------------------------------------

void check_commands(const ros::JointState& message) {
  const JointCommands read = read_commands(message, find_joint);
  for (const std::string& problem : read.problems) check_sentence(problem);
  std::set<std::size_t> seen;
  for (const JointCommand& command : read.commands) {
    demand(std::isfinite(command.value), "a command has a number");
    demand(command.joint.place < kJoints, "and a joint that is known");
    demand(seen.insert(command.joint.place).second, "and no other one has its joint");
  }
}

/// Tolerance for rounding in the check of a path, and for extrema between the parts into which the
/// check divides a polynomial.
bool is_within(double value, double limit) {
  constexpr double kRoom = 1e-3;
  return std::abs(value) <= limit + kRoom * std::max(1.0, limit);
}

void check_path(const JointMotion& start, std::span<const PathPoint> points) {
  const JointPath path(start, points);
  if (const auto broken = path.check(limits(), "rad")) {
    check_sentence(*broken);
    return;
  }
  constexpr int kSamples = 97;
  for (int i = 0; i <= kSamples; ++i) {
    const JointMotion motion = path.at(path.duration() * i / kSamples);
    demand(is_within(motion.position, limits().upper), "a path keeps the position limits");
    demand(is_within(motion.velocity, limits().velocity), "and that of the velocity");
    demand(is_within(motion.acceleration, limits().acceleration), "and that of the acceleration");
  }
  const JointMotion end = path.at(path.duration());
  demand(std::abs(end.position - points.back().position) < 1e-6 && end.velocity == 0.0,
         "and rests at its last point");
}

void check_trajectory(const ros::JointTrajectory& message) {
  std::string problem;
  const auto trajectory = read_trajectory(message, find_joint, problem);
  if (!trajectory) {
    check_sentence(problem);
    return;
  }
  for (std::size_t joint = 0; joint < trajectory->joints.size(); ++joint) {
    std::vector<PathPoint> points;
    for (const TrajectoryPoint& point : trajectory->points) {
      if (point.time <= 0.0) continue;
      PathPoint& added = points.emplace_back();
      added.time = point.time;
      added.position = point.positions[joint];
      if (!point.velocities.empty()) added.velocity = point.velocities[joint];
      if (!point.accelerations.empty()) added.acceleration = point.accelerations[joint];
    }
    if (points.empty()) continue;
    check_path({}, points);
    check_path({.position = 0.5, .velocity = -1.0, .acceleration = 0.0}, points);
  }
}

void check_tracker(Bytes& bytes) {
  constexpr double kPeriod = 1e-3;
  constexpr double kStep = 1.0 / 4096.0;
  const JointLimits most = limits();
  JointTracker tracker({});
  JointMotion last{};
  while (!bytes.empty()) {
    const double goal = bytes.take<std::int16_t>() * kStep;
    const std::size_t choice = bytes.below(8);
    if (choice == 0) tracker.stop(most);
    if (choice > 1) tracker.go_to(goal, static_cast<double>(bytes.take()) * kPeriod);
    const std::size_t steps = bytes.below(64);
    for (std::size_t i = 0; i < steps; ++i) {
      const JointMotion now = tracker.step(kPeriod, most);
      const double gain = std::abs(now.velocity - last.velocity);
      demand(std::abs(now.velocity) <= most.velocity * (1.0 + 1e-9), "it keeps the velocity");
      demand(gain <= 2.0 * most.ramp * kPeriod * (1.0 + 1e-9), "and its ramps");
      demand(std::abs(now.position - last.position) <= most.velocity * kPeriod * (1.0 + 1e-9),
             "and never jumps");
      last = now;
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes({data, size});
  switch (bytes.below(5)) {
    case 0: {
      ros::JointState message;
      if (decode(bytes.take_span(size), message)) check_commands(message);
      break;
    }
    case 1: {
      ros::JointTrajectory message;
      if (decode(bytes.take_span(size), message)) check_trajectory(message);
      break;
    }
    case 2:
      check_commands(take_state(bytes));
      break;
    case 3:
      check_trajectory(take_trajectory(bytes));
      break;
    default:
      check_tracker(bytes);
  }
  return 0;
}
