// SPDX-License-Identifier: Apache-2.0
#include "requests.hpp"

#include "joint_limits.hpp"
#include "ros_time.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace vdrive::ros2 {
namespace {

/// The places in `name` to which the values of an array belong; empty if they are ambiguous.
std::vector<std::size_t> places_of(const std::vector<std::optional<JointPlace>>& joints,
                                   CommandInterface interface, std::size_t values) {
  std::vector<std::size_t> places;
  places.reserve(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const bool is_meant =
        values == joints.size() || (joints[i] && joints[i]->interface == interface);
    if (is_meant) places.push_back(i);
  }
  if (places.size() != values) places.clear();
  return places;
}

/// Reads the commands of one message for each of its joints.
class CommandReader {
 public:
  CommandReader(const ros::JointState& message, const FindJoint& find)
      : names_(message.name), chosen_(names_.size()) {
    std::set<std::string> seen;
    joints_.reserve(names_.size());
    for (const std::string& name : names_) {
      std::string reason;
      joints_.push_back(find(name, reason));
      // The other joints of the message still move: a robot may have joints that are on no bench.
      if (!joints_.back()) problem("joint " + in_quotes(name) + " " + reason + ": ignored");
      if (!seen.insert(name).second) {
        problem("joint " + in_quotes(name) + " is named twice: ignored");
        joints_.back().reset();
      }
    }
  }

  void read(CommandInterface interface, const std::vector<double>& values) {
    if (values.empty()) return;
    const auto places = places_of(joints_, interface, values.size());
    if (places.empty()) {
      problem(std::string(to_string(interface)) + " has " + std::to_string(values.size()) +
              " values for " + std::to_string(names_.size()) +
              " names: ignored; give each joint its interface in the configuration");
      return;
    }
    for (std::size_t i = 0; i < values.size(); ++i) take(places[i], interface, values[i]);
  }

  JointCommands result() {
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      if (chosen_[i] && joints_[i]) result_.commands.push_back(*chosen_[i]);
    }
    return std::move(result_);
  }

 private:
  void problem(std::string text) { result_.problems.push_back(std::move(text)); }

  void take(std::size_t place, CommandInterface interface, double value) {
    std::optional<JointPlace>& joint = joints_[place];
    if (!joint || !std::isfinite(value)) return;
    const std::string name = "joint " + in_quotes(names_[place]);
    if (joint->interface && joint->interface != interface) {
      problem(name + " is commanded by " + std::string(to_string(*joint->interface)) + ": its " +
              std::string(to_string(interface)) + " is ignored");
      return;
    }
    if (chosen_[place]) {
      problem(name + " has a " + std::string(to_string(chosen_[place]->interface)) + " and a " +
              std::string(to_string(interface)) + ": refused, one interface at a time");
      joint.reset();  // neither value is used: the bridge does not choose
      return;
    }
    chosen_[place] = JointCommand{.joint = *joint, .interface = interface, .value = value};
  }

  const std::vector<std::string>& names_;
  std::vector<std::optional<JointPlace>> joints_;
  std::vector<std::optional<JointCommand>> chosen_;
  JointCommands result_;
};

bool all_finite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) {
    return std::isfinite(value);
  });
}

/// @return the error in a point; empty if it is valid.
std::string check_point(const ros::JointTrajectoryPoint& point, std::size_t joints) {
  struct Array {
    const char* name;
    const std::vector<double>& values;
    bool may_be_empty;
  };

  const std::array arrays{Array{"positions", point.positions, false},
                          Array{"velocities", point.velocities, true},
                          Array{"accelerations", point.accelerations, true}};
  for (const Array& array : arrays) {
    const bool has_size =
        array.values.size() == joints || (array.may_be_empty && array.values.empty());
    if (!has_size) {
      return "has " + std::to_string(array.values.size()) + " " + array.name + " for " +
             std::to_string(joints) + " joints";
    }
    if (!all_finite(array.values))
      return "has " + std::string(array.name) + " that are not numbers";
  }
  if (!point.effort.empty())
    return "has effort, which is not supported: a trajectory follows positions";
  return {};
}

bool find_joints(const ros::JointTrajectory& message, const FindJoint& find, Trajectory& trajectory,
                 std::string& problem) {
  std::set<std::string> seen;
  for (const std::string& name : message.joint_names) {
    std::string reason;
    const auto joint = find(name, reason);
    const std::string text = "joint " + in_quotes(name);
    if (!joint) problem = text + " " + reason;
    if (joint &&
        joint->interface.value_or(CommandInterface::position) != CommandInterface::position) {
      problem = text + " is commanded by " + std::string(to_string(*joint->interface));
    }
    if (!seen.insert(name).second) problem = text + " is named twice";
    if (!problem.empty()) return false;
    trajectory.joints.push_back(*joint);
    trajectory.names.push_back(name);
  }
  if (seen.empty()) problem = "it names no joint";
  return problem.empty();
}

}  // namespace

JointCommands read_commands(const ros::JointState& message, const FindJoint& find) {
  CommandReader reader(message, find);
  reader.read(CommandInterface::position, message.position);
  reader.read(CommandInterface::velocity, message.velocity);
  reader.read(CommandInterface::effort, message.effort);
  return reader.result();
}

std::optional<Trajectory> read_trajectory(const ros::JointTrajectory& message,
                                          const FindJoint& find, std::string& problem) {
  Trajectory trajectory;
  problem.clear();
  if (!find_joints(message, find, trajectory, problem)) return std::nullopt;
  if (message.points.empty()) problem = "it has no points";
  double last = -1.0;  // the first point may be at time 0
  trajectory.points.reserve(message.points.size());
  for (std::size_t i = 0; i < message.points.size() && problem.empty(); ++i) {
    const auto& point = message.points[i];
    const std::string what = "point " + std::to_string(i + 1) + " ";
    const double time =
        point.time_from_start.sec + point.time_from_start.nanosec * kSecondsPerNanosecond;
    const std::string wrong = check_point(point, trajectory.joints.size());
    if (!wrong.empty()) problem = what + wrong;
    if (problem.empty() && (time <= last || time < 0.0)) {
      problem =
          what + "is at " + text_of(time) + " s, not after the previous one: times must increase";
    }
    last = time;
    trajectory.points.push_back({.time = time,
                                 .positions = point.positions,
                                 .velocities = point.velocities,
                                 .accelerations = point.accelerations});
  }
  if (!problem.empty()) return std::nullopt;
  const auto moves = [](double velocity) {
    return velocity != 0.0;
  };
  // Nothing follows the last point: the joint would stop within a tick.
  if (std::ranges::any_of(trajectory.points.back().velocities, moves)) {
    problem = "the last point has a velocity, which must be 0";
    return std::nullopt;
  }
  trajectory.start = nanoseconds_of(message.header.stamp);
  return trajectory;
}

}  // namespace vdrive::ros2
