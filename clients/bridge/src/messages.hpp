// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_values.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/event.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What benches publish, as messages of ROS 2: their schemas as ros2msg text, and their bytes as
/// CDR. The members of the status come from the table of the core. A time is drive time [ns].
namespace vdrive::bridge {

/// Name and text of a message type. The text has the types that it uses after it, each after a
/// line of 80 equals signs, as rosbag2 writes them.
struct MessageSchema {
  std::string name;
  std::string text;
};

/// vdrive_msgs/msg/BenchStatus: all axes of a bench after one tick, an array a member.
[[nodiscard]] MessageSchema bench_status_schema();

/// vdrive_msgs/msg/AxisStatus: one axis after one tick.
[[nodiscard]] MessageSchema axis_status_schema();

/// vdrive_msgs/msg/AxisTrace: one axis after each tick since the message before.
[[nodiscard]] MessageSchema axis_trace_schema();

/// vdrive_msgs/msg/AxisParameters: every object of one axis, read in one go.
[[nodiscard]] MessageSchema axis_parameters_schema();

/// foxglove.Log.
[[nodiscard]] MessageSchema log_schema();

/// @return the LogLevel of foxglove.Log: 2 = info, 3 = warning, 4 = error.
[[nodiscard]] std::uint8_t log_level(client::EventKind kind);

/// @return what people read about an event, with the number of equal ones left out before it.
[[nodiscard]] std::string event_text(const client::Event& event);

/// foxglove.JointStates: rad, rad/s and N.m, or m, m/s and N. The status has no acceleration and
/// the schema nothing that is absent: it is NaN.
[[nodiscard]] MessageSchema joint_states_schema();

/// Some ticks of one axis, one after the other.
struct Trace {
  std::uint16_t axis = 0;
  std::uint64_t missed = 0;  ///< ticks that did not arrive, since the first one
  std::vector<std::uint64_t> ticks;
  std::vector<AxisStatus> status;  ///< as many as `ticks`
};

/// What the objects of one axis were when they were read.
struct ParameterImage {
  client::AxisId axis;
  std::uint64_t tick = 0;                      ///< in which the last of them was read
  std::vector<client::ObjectReading> objects;  ///< in any order
};

/// One joint of a JointStates message.
struct Joint {
  std::string_view name;
  JointScale scale{};
};

[[nodiscard]] std::string encode_bench_status(const client::Observation& observation,
                                              std::uint64_t time);
[[nodiscard]] std::string encode_axis_status(const client::AxisSnapshot& axis, std::uint64_t time);
[[nodiscard]] std::string encode_axis_trace(const Trace& trace, std::uint64_t time);

/// An object that `image` has no value of is 0, and stands in `refused` as index x 256 + sub-index.
[[nodiscard]] std::string encode_axis_parameters(const ParameterImage& image, std::uint64_t time);

/// @param name what the event is about, such as "bench1/x"
[[nodiscard]] std::string encode_event(const client::Event& event, std::string_view name,
                                       std::uint64_t time);

/// @param joints one for each axis of the observation
[[nodiscard]] std::string encode_joint_states(const client::Observation& observation,
                                              std::span<const Joint> joints, std::uint64_t time);

}  // namespace vdrive::bridge
