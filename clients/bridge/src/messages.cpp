// SPDX-License-Identifier: Apache-2.0
#include "messages.hpp"

#include "axis_fields.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/wire/cdr.hpp"

#include <limits>
#include <optional>
#include <tuple>

namespace vdrive::bridge {
namespace {

struct RosTime {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};

struct FoxgloveJoint {
  std::string_view name;
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
  double effort = 0.0;
};

}  // namespace
}  // namespace vdrive::bridge

namespace vdrive::wire {

template <>
struct Description<bridge::RosTime> {
  using Struct = bridge::RosTime;
  static constexpr std::string_view kName = "builtin_interfaces/Time";
  static constexpr std::tuple kMembers{Member{{"sec"}, &Struct::sec},
                                       Member{{"nanosec"}, &Struct::nanosec}};
};

template <>
struct Description<bridge::FoxgloveJoint> {
  using Struct = bridge::FoxgloveJoint;
  static constexpr std::string_view kName = "foxglove_msgs/JointState";
  static constexpr std::tuple kMembers{
      Member{{"name"}, &Struct::name}, Member{{"position"}, &Struct::position},
      Member{{"velocity"}, &Struct::velocity}, Member{{"acceleration"}, &Struct::acceleration},
      Member{{"effort"}, &Struct::effort}};
};

}  // namespace vdrive::wire

namespace vdrive::bridge {
namespace {

/// Builds the text of a schema from the fields of a message.
class SchemaText {
 public:
  template <typename Value>
  void operator()(std::string_view name, const Value& /*value*/) {
    add(type_of<Value>(), name);
  }

  /// A sequence of the results of `value_of` for each element.
  template <typename Elements, typename ValueOf>
  void operator()(std::string_view name, const Elements& /*elements*/,
                  const ValueOf& /*value_of*/) {
    add(type_of<wire::CdrElement<Elements, ValueOf>>() + "[]", name);
  }

  [[nodiscard]] std::string text() const { return fields_ + used_; }

 private:
  void add(const std::string& type, std::string_view name) {
    fields_.append(type).append(" ").append(name).append("\n");
  }

  /// @return a type such as "uint16" or "uint16[]".
  template <typename Value>
  std::string type_of() {
    if constexpr (wire::CdrNumber<Value>) {
      const std::string kind = std::is_floating_point_v<Value> ? "float"
                               : std::is_signed_v<Value>       ? "int"
                                                               : "uint";
      return kind + std::to_string(8 * sizeof(Value));
    } else if constexpr (wire::CdrSequence<Value>) {
      return type_of<wire::CdrElement<Value>>() + "[]";
    } else if constexpr (wire::DescribedStruct<Value>) {
      use<Value>();
      return std::string(wire::Description<Value>::kName);
    } else {
      return "string";
    }
  }

  /// The definition of a nested type follows after a line of 80 equals signs.
  template <typename Struct>
  void use() {
    SchemaText own;
    wire::for_each_member<Struct>([&](const auto& member) {
      own(member.name, Struct{}.*member.pointer);
    });
    used_ = std::string(80, '=') + "\nMSG: " + std::string(wire::Description<Struct>::kName) +
            "\n" + own.text() + used_;
  }

  std::string fields_;
  std::string used_;
};

/// @param message one of those below
/// @param source its data except for the time; only the types matter
template <typename Message, typename... Source>
MessageSchema schema_of(std::string name, const Message& message, const Source&... source) {
  SchemaText schema;
  message(schema, source..., std::uint64_t{0});
  return {.name = std::move(name), .text = schema.text()};
}

template <typename Message, typename... Source>
std::string encode(const Message& message, const Source&... source) {
  std::string bytes;
  wire::write_sample(bytes, [&](wire::CdrWriter& writer) {
    const auto put = [&](std::string_view /*name*/, const auto&... value) {
      writer.put(value...);
    };
    message(put, source...);
  });
  return bytes;
}

// ---- messages: each calls `field` for its fields ------------------------------------------------

/// Seconds beyond 2^31 - 1 wrap around, as they do in ROS.
RosTime ros_time(std::uint64_t nanoseconds) {
  constexpr std::uint64_t kSecond = 1'000'000'000;  // [ns]
  return {.sec = static_cast<std::int32_t>(nanoseconds / kSecond),
          .nanosec = static_cast<std::uint32_t>(nanoseconds % kSecond)};
}

constexpr auto kBenchStatus = [](auto& field, const client::Observation& observation,
                                 std::uint64_t time) {
  field("stamp", ros_time(time));
  field("tick", observation.tick);
  for_each_axis_field([&](std::string_view name, auto field_of) {
    field(name, observation.axes, field_of);
  });
};

constexpr auto kAxisStatus = [](auto& field, const client::AxisSnapshot& axis, std::uint64_t time) {
  field("stamp", ros_time(time));
  field("tick", axis.tick);
  for_each_axis_field([&](std::string_view name, auto field_of) {
    field(name, field_of(axis));
  });
};

constexpr auto kAxisTrace = [](auto& field, const Trace& trace, std::uint64_t time) {
  field("stamp", ros_time(time));
  field("axis", trace.axis);
  field("missed", trace.missed);
  field("tick", trace.ticks);
  for_each_published_member([&](std::string_view name, auto member) {
    field(name, trace.status, member);
  });
};

constexpr auto kAxisParameters = [](auto& field, const ParameterImage& image, std::uint64_t time) {
  std::vector<std::optional<std::int64_t>> values(kObjectTable.size());
  for (const client::ObjectReading& reading : image.objects) {
    const auto row = find_object(reading.object);
    if (row && reading.code == AbortCode::none) values[*row] = reading.value;
  }
  field("stamp", ros_time(time));
  field("tick", image.tick);
  field("axis", image.axis.axis);
  std::vector<std::uint32_t> refused;
  for (std::size_t row = 0; row < kObjectTable.size(); ++row) {
    const ObjectDescription& object = kObjectTable[row];
    with_type(object.data_type, [&]<typename Number>(Number /*any*/) {
      field(object.variable_name, static_cast<Number>(values[row].value_or(0)));
    });
    if (!values[row]) refused.push_back(object.address.index * 256U + object.address.subindex);
  }
  field("refused", refused);
};

constexpr auto kLog = [](auto& field, const client::Event& event, std::string_view name,
                         std::uint64_t time) {
  field("timestamp", ros_time(time));
  field("level", log_level(event.kind));
  field("message", event_text(event));
  field("name", name);
  // Log panels filter by file, so `file` has the kind of the event.
  field("file", to_string(event.kind));
  field("line", std::uint32_t{0});  // no line
};

constexpr auto kJointStates = [](auto& field, const std::vector<FoxgloveJoint>& joints,
                                 std::uint64_t time) {
  field("timestamp", ros_time(time));
  field("joints", joints);
};

}  // namespace

MessageSchema bench_status_schema() {
  return schema_of("vdrive_msgs/msg/BenchStatus", kBenchStatus, client::Observation{});
}

MessageSchema axis_status_schema() {
  return schema_of("vdrive_msgs/msg/AxisStatus", kAxisStatus, client::AxisSnapshot{});
}

MessageSchema axis_trace_schema() {
  return schema_of("vdrive_msgs/msg/AxisTrace", kAxisTrace, Trace{});
}

MessageSchema axis_parameters_schema() {
  return schema_of("vdrive_msgs/msg/AxisParameters", kAxisParameters, ParameterImage{});
}

MessageSchema log_schema() {
  MessageSchema schema = schema_of("foxglove.Log", kLog, client::Event{}, "");
  schema.text.insert(0,
                     "uint8 UNKNOWN=0\n"
                     "uint8 DEBUG=1\n"
                     "uint8 INFO=2\n"
                     "uint8 WARNING=3\n"
                     "uint8 ERROR=4\n"
                     "uint8 FATAL=5\n");
  return schema;
}

MessageSchema joint_states_schema() {
  return schema_of("foxglove.JointStates", kJointStates, std::vector<FoxgloveJoint>());
}

std::string encode_bench_status(const client::Observation& observation, std::uint64_t time) {
  return encode(kBenchStatus, observation, time);
}

std::string encode_axis_status(const client::AxisSnapshot& axis, std::uint64_t time) {
  return encode(kAxisStatus, axis, time);
}

std::string encode_axis_trace(const Trace& trace, std::uint64_t time) {
  return encode(kAxisTrace, trace, time);
}

std::string encode_axis_parameters(const ParameterImage& image, std::uint64_t time) {
  return encode(kAxisParameters, image, time);
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
    text.append(" (").append(std::to_string(event.suppressed)).append(" more suppressed)");
  }
  return text;
}

std::string encode_event(const client::Event& event, std::string_view name, std::uint64_t time) {
  return encode(kLog, event, name, time);
}

std::string encode_joint_states(const client::Observation& observation,
                                std::span<const Joint> joints, std::uint64_t time) {
  ensure(joints.size() <= observation.axes.size(), "each joint is an axis of the observation");
  // The status has no acceleration, and differences of velocities in user units would be mostly
  // rounding.
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<FoxgloveJoint> states;
  states.reserve(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const JointValues values = joint_values(observation.axes[i].status, joints[i].scale);
    states.push_back({.name = joints[i].name,
                      .position = values.position,
                      .velocity = values.velocity,
                      .acceleration = kUnknown,
                      .effort = values.effort});
  }
  return encode(kJointStates, states, time);
}

}  // namespace vdrive::bridge
