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

/// The publications of benches as ROS 2 messages: schemas as ros2msg text, and contents as CDR. The
/// members of the status come from the table in the core. Times are drive time [ns].
namespace vdrive::bridge {

/// Name and text of a message type. The types that it uses are appended to the text, each after a
/// line of 80 equals signs, as rosbag2 writes them.
struct MessageSchema {
  std::string name;
  std::string text;
};

/// vdrive_msgs/msg/BenchStatus: all axes of a bench after one tick, one array per member.
[[nodiscard]] MessageSchema bench_status_schema();

/// vdrive_msgs/msg/AxisStatus: one axis after one tick.
[[nodiscard]] MessageSchema axis_status_schema();

/// vdrive_msgs/msg/AxisTrace: one axis after each tick since the previous message.
[[nodiscard]] MessageSchema axis_trace_schema();

/// vdrive_msgs/msg/AxisParameters: all objects of one axis, read together.
[[nodiscard]] MessageSchema axis_parameters_schema();

/// foxglove.Log.
[[nodiscard]] MessageSchema log_schema();

/// @return the LogLevel of foxglove.Log: 2 = info, 3 = warning, 4 = error.
[[nodiscard]] std::uint8_t log_level(client::EventKind kind);

/// @return the readable text of an event, with the number of equal ones suppressed before it.
[[nodiscard]] std::string event_text(const client::Event& event);

/// foxglove.JointStates: rad, rad/s and N.m, or m, m/s and N. The acceleration is NaN: the status
/// has none, and the schema has no optional fields.
[[nodiscard]] MessageSchema joint_states_schema();

/// Consecutive ticks of one axis.
struct Trace {
  std::uint16_t axis = 0;
  std::uint64_t missed = 0;  ///< ticks lost since the first one
  std::vector<std::uint64_t> ticks;
  std::vector<AxisStatus> status;  ///< as many as `ticks`
};

/// The values of the objects of one axis when they were read.
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

/// Objects without a value in `image` are 0 and are listed in `refused` as index x 256 + sub-index.
[[nodiscard]] std::string encode_axis_parameters(const ParameterImage& image, std::uint64_t time);

/// @param name the subject of the event, such as "bench1/x"
[[nodiscard]] std::string encode_event(const client::Event& event, std::string_view name,
                                       std::uint64_t time);

/// @param joints one per axis of the observation
[[nodiscard]] std::string encode_joint_states(const client::Observation& observation,
                                              std::span<const Joint> joints, std::uint64_t time);

}  // namespace vdrive::bridge
