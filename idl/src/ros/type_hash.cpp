// SPDX-License-Identifier: Apache-2.0
// Descriptions and hashes of types as rosidl makes them (REP 2011, REP 2016).
#include "vdrive/wire/ros_types.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

namespace vdrive::ros {
namespace {

/// Numbers of type_description_interfaces/msg/FieldType.
enum FieldType : std::uint8_t {
  nested = 1,
  uint8_type = 3,
  int32_type = 6,
  uint32_type = 7,
  double_type = 11,
  boolean_type = 15,
  byte_type = 16,
  string_type = 17,
};

constexpr int kSequence = 144;  // of any length, added to the number of its elements

struct Field {
  std::string_view name;
  FieldType type = nested;
  bool is_sequence = false;
  std::string_view nested_type{};
};

struct Description {
  std::string_view name;
  std::span<const Field> fields;
};

constexpr std::string_view kTime = "builtin_interfaces/msg/Time";
constexpr std::string_view kDuration = "builtin_interfaces/msg/Duration";
constexpr std::string_view kHeader = "std_msgs/msg/Header";
constexpr std::string_view kPoint = "trajectory_msgs/msg/JointTrajectoryPoint";
constexpr std::string_view kStatus = "diagnostic_msgs/msg/DiagnosticStatus";
constexpr std::string_view kKeyValue = "diagnostic_msgs/msg/KeyValue";

constexpr std::array kTimeFields{Field{"sec", int32_type}, Field{"nanosec", uint32_type}};
constexpr std::array kHeaderFields{Field{"stamp", nested, false, kTime},
                                   Field{"frame_id", string_type}};
constexpr std::array kBoolFields{Field{"data", boolean_type}};
constexpr std::array kJointStateFields{
    Field{"header", nested, false, kHeader}, Field{"name", string_type, true},
    Field{"position", double_type, true}, Field{"velocity", double_type, true},
    Field{"effort", double_type, true}};
constexpr std::array kPointFields{
    Field{"positions", double_type, true}, Field{"velocities", double_type, true},
    Field{"accelerations", double_type, true}, Field{"effort", double_type, true},
    Field{"time_from_start", nested, false, kDuration}};
constexpr std::array kTrajectoryFields{Field{"header", nested, false, kHeader},
                                       Field{"joint_names", string_type, true},
                                       Field{"points", nested, true, kPoint}};
constexpr std::array kKeyValueFields{Field{"key", string_type}, Field{"value", string_type}};
constexpr std::array kStatusFields{Field{"level", byte_type}, Field{"name", string_type},
                                   Field{"message", string_type}, Field{"hardware_id", string_type},
                                   Field{"values", nested, true, kKeyValue}};
constexpr std::array kDiagnosticsFields{Field{"header", nested, false, kHeader},
                                        Field{"status", nested, true, kStatus}};
constexpr std::array kClockFields{Field{"clock", nested, false, kTime}};
constexpr std::array kLogFields{Field{"stamp", nested, false, kTime},
                                Field{"level", uint8_type},
                                Field{"name", string_type},
                                Field{"msg", string_type},
                                Field{"file", string_type},
                                Field{"function", string_type},
                                Field{"line", uint32_type}};

constexpr std::array kTypes{
    Description{kTime, kTimeFields},
    Description{kDuration, kTimeFields},
    Description{kHeader, kHeaderFields},
    Description{"std_msgs/msg/Bool", kBoolFields},
    Description{"sensor_msgs/msg/JointState", kJointStateFields},
    Description{kPoint, kPointFields},
    Description{"trajectory_msgs/msg/JointTrajectory", kTrajectoryFields},
    Description{kKeyValue, kKeyValueFields},
    Description{kStatus, kStatusFields},
    Description{"diagnostic_msgs/msg/DiagnosticArray", kDiagnosticsFields},
    Description{"rosgraph_msgs/msg/Clock", kClockFields},
    Description{"rcl_interfaces/msg/Log", kLogFields},
};

const Description& description_of(std::string_view type) {
  const auto* const found = std::ranges::find(kTypes, type, &Description::name);
  if (found == kTypes.end()) throw std::invalid_argument("no type " + std::string(type));
  return *found;
}

std::string field_json(const Field& field) {
  const int number = field.type + (field.is_sequence ? kSequence : 0);
  return R"({"name": ")" + std::string(field.name) + R"(", "type": {"type_id": )" +
         std::to_string(number) +
         R"(, "capacity": 0, "string_capacity": 0, "nested_type_name": ")" +
         std::string(field.nested_type) + R"("}})";
}

std::string type_json(const Description& type) {
  std::string json = R"({"type_name": ")" + std::string(type.name) + R"(", "fields": [)";
  for (const Field& field : type.fields) {
    if (json.back() != '[') json += ", ";
    json += field_json(field);
  }
  return json + "]}";
}

void add_used(const Description& type, std::set<std::string_view>& used) {
  for (const Field& field : type.fields) {
    if (field.type != nested) continue;
    used.insert(field.nested_type);
    add_used(description_of(field.nested_type), used);
  }
}

}  // namespace

std::string type_description(std::string_view type) {
  const Description& own = description_of(type);
  std::set<std::string_view> used;
  add_used(own, used);
  std::string json =
      R"({"type_description": )" + type_json(own) + R"(, "referenced_type_descriptions": [)";
  for (const std::string_view name : used) {
    if (json.back() != '[') json += ", ";
    json += type_json(description_of(name));
  }
  return json + "]}";
}

std::string type_hash(std::string_view type) {
  const std::string text = type_description(type);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("OpenSSL has no SHA-256");
  }
  constexpr std::string_view kDigits = "0123456789abcdef";
  constexpr unsigned int kHalfByte = 4;
  constexpr unsigned int kLowHalf = 15;
  std::string hash = "RIHS01_";
  for (unsigned int i = 0; i < size; ++i) {
    hash += kDigits[digest[i] >> kHalfByte];
    hash += kDigits[digest[i] & kLowHalf];
  }
  return hash;
}

}  // namespace vdrive::ros
