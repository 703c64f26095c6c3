// SPDX-License-Identifier: Apache-2.0
#include "messages.hpp"

#include "cdr_writer.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

namespace vdrive::bridge {
namespace {

const std::vector<StatusMember>& published_members() {
  static const std::vector<StatusMember> members = [] {
    std::vector<StatusMember> published;
    std::ranges::copy_if(status_members(), std::back_inserter(published),
                         &StatusMember::is_published);
    return published;
  }();
  return members;
}

/// @return such as "uint16".
std::string ros_type(DataType type) {
  constexpr std::array kSigned{DataType::integer8, DataType::integer16, DataType::integer32};
  const bool is_signed = std::ranges::count(kSigned, type) > 0;
  return (is_signed ? "int" : "uint") + std::to_string(8 * size_of(type));
}

/// A line for each published member of the status.
/// @param suffix of the types: "[]" or nothing
std::string member_lines(std::string_view suffix) {
  std::string text;
  for (const StatusMember& member : published_members()) {
    text.append(ros_type(member.data_type)).append(suffix).append(" ");
    text.append(member.name).append("\n");
  }
  return text;
}

/// The lines of the published members, and those of the owner.
/// @param suffix as above
std::string status_lines(const std::string& suffix) {
  return member_lines(suffix) + "uint64" + suffix + " owner_session\nuint32" + suffix +
         " owner_epoch\nuint64" + suffix + " last_sequence\n";
}

/// The text of a type that another one uses: it stands behind a line of 80 equals signs.
std::string used_type(const std::string& name, const std::string& text) {
  return std::string(80, '=') + "\nMSG: " + name + "\n" + text;
}

std::string with_time(const std::string& text) {
  return text + used_type("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
}

/// The bytes of a message that begins with its time.
struct TimedMessage {
  std::string bytes;
  CdrWriter writer{bytes};

  explicit TimedMessage(std::uint64_t time, std::size_t size = 0) {
    bytes.reserve(size);
    writer.put_time(time);
  }
};

}  // namespace

MessageSchema bench_status_schema() {
  return {.name = "vdrive_msgs/msg/BenchStatus",
          .text = with_time("builtin_interfaces/Time stamp\nuint64 tick\nuint16[] axis\n" +
                            status_lines("[]"))};
}

MessageSchema axis_status_schema() {
  return {.name = "vdrive_msgs/msg/AxisStatus",
          .text = with_time("builtin_interfaces/Time stamp\nuint64 tick\nuint16 axis\n" +
                            status_lines(""))};
}

MessageSchema axis_trace_schema() {
  return {.name = "vdrive_msgs/msg/AxisTrace",
          .text = with_time("builtin_interfaces/Time stamp\n"
                            "uint16 axis\n"
                            "uint64 missed\n"
                            "uint64[] tick\n" +
                            member_lines("[]"))};
}

MessageSchema axis_parameters_schema() {
  std::string text =
      "builtin_interfaces/Time stamp\n"
      "uint64 tick\n"
      "uint16 axis\n";
  for (const ObjectDescription& object : kObjectTable) {
    text.append(ros_type(object.data_type)).append(" ");
    text.append(object.variable_name).append("\n");
  }
  return {.name = "vdrive_msgs/msg/AxisParameters",
          .text = with_time(text.append("uint32[] refused\n"))};
}

MessageSchema log_schema() {
  return {.name = "foxglove.Log",
          .text = with_time("uint8 UNKNOWN=0\n"
                            "uint8 DEBUG=1\n"
                            "uint8 INFO=2\n"
                            "uint8 WARNING=3\n"
                            "uint8 ERROR=4\n"
                            "uint8 FATAL=5\n"
                            "builtin_interfaces/Time timestamp\n"
                            "uint8 level\n"
                            "string message\n"
                            "string name\n"
                            "string file\n"
                            "uint32 line\n")};
}

MessageSchema joint_states_schema() {
  return {.name = "foxglove.JointStates",
          .text = with_time("builtin_interfaces/Time timestamp\n"
                            "foxglove_msgs/JointState[] joints\n" +
                            used_type("foxglove_msgs/JointState",
                                      "string name\n"
                                      "float64 position\n"
                                      "float64 velocity\n"
                                      "float64 acceleration\n"
                                      "float64 effort\n"))};
}

std::string encode_bench_status(const client::Observation& observation, std::uint64_t time) {
  constexpr std::size_t kBytesOfAxis = 96;
  using client::AxisSnapshot;
  TimedMessage message(time, (observation.axes.size() + 4) * kBytesOfAxis);
  CdrWriter& writer = message.writer;
  writer.put(observation.tick);
  writer.put_sequence(observation.axes, [](const AxisSnapshot& axis) {
    return axis.id.axis;
  });
  for (const StatusMember& member : published_members()) {
    writer.put_sequence(member.data_type, observation.axes, [&](const AxisSnapshot& axis) {
      return member.value(axis.status);
    });
  }
  writer.put_sequence(observation.axes, &AxisSnapshot::owner_session);
  writer.put_sequence(observation.axes, &AxisSnapshot::owner_epoch);
  writer.put_sequence(observation.axes, &AxisSnapshot::last_sequence);
  return std::move(message.bytes);
}

std::string encode_axis_status(const client::AxisSnapshot& axis, std::uint64_t time) {
  TimedMessage message(time);
  CdrWriter& writer = message.writer;
  writer.put(axis.tick);
  writer.put(axis.id.axis);
  for (const StatusMember& member : published_members()) {
    writer.put(member.data_type, member.value(axis.status));
  }
  writer.put(axis.owner_session);
  writer.put(axis.owner_epoch);
  writer.put(axis.last_sequence);
  return std::move(message.bytes);
}

std::string encode_axis_trace(const Trace& trace, std::uint64_t time) {
  TimedMessage message(time);
  CdrWriter& writer = message.writer;
  writer.put(trace.axis);
  writer.put(trace.missed);
  writer.put_sequence(trace.ticks);
  for (const StatusMember& member : published_members()) {
    writer.put_sequence(member.data_type, trace.status, [&](const AxisStatus& status) {
      return member.value(status);
    });
  }
  return std::move(message.bytes);
}

std::string encode_axis_parameters(const ParameterImage& image, std::uint64_t time) {
  std::vector<std::optional<std::int64_t>> values(kObjectTable.size());
  for (const client::ObjectReading& reading : image.objects) {
    const auto row = find_object(reading.object);
    if (row && reading.code == AbortCode::none) values[*row] = reading.value;
  }
  TimedMessage message(time);
  message.writer.put(image.tick);
  message.writer.put(image.axis.axis);
  std::vector<std::uint32_t> refused;
  refused.reserve(kObjectTable.size());
  for (std::size_t row = 0; row < kObjectTable.size(); ++row) {
    const ObjectDescription& object = kObjectTable[row];
    message.writer.put(object.data_type, values[row].value_or(0));
    if (!values[row]) refused.push_back(object.address.index * 256U + object.address.subindex);
  }
  message.writer.put_sequence(refused);
  return std::move(message.bytes);
}

std::uint8_t log_level(client::EventKind kind) {
  switch (severity_of(kind)) {
    case client::EventSeverity::error:
      return 4;
    case client::EventSeverity::warning:
      return 3;
    case client::EventSeverity::info:
      break;
  }
  return 2;
}

std::string event_text(const client::Event& event) {
  std::string text = event.text;
  if (event.suppressed != 0) {
    text.append(" (").append(std::to_string(event.suppressed)).append(" more left out before)");
  }
  return text;
}

std::string encode_event(const client::Event& event, std::string_view name, std::uint64_t time) {
  const std::string text = event_text(event);
  TimedMessage message(time);
  message.writer.put(log_level(event.kind));
  message.writer.put(std::string_view(text));
  message.writer.put(name);
  // Log panels filter by file: here it is the kind of the event.
  message.writer.put(to_string(event.kind));
  message.writer.put(std::uint32_t{0});  // no line
  return std::move(message.bytes);
}

std::string encode_joint_states(const client::Observation& observation,
                                std::span<const Joint> joints, std::uint64_t time) {
  // The status has none, and the differences of velocities in user units are mostly their rounding.
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  ensure(joints.size() <= observation.axes.size(), "each joint is an axis of the observation");
  TimedMessage message(time);
  message.writer.put_count(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const JointValues values = joint_values(observation.axes[i].status, joints[i].scale);
    message.writer.put(joints[i].name);
    for (const double value : {values.position, values.velocity, kUnknown, values.effort}) {
      message.writer.put(value);
    }
  }
  return std::move(message.bytes);
}

}  // namespace vdrive::bridge
