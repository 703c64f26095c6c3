// SPDX-License-Identifier: Apache-2.0
// Descriptions and hashes of types as rosidl makes them (REP 2011, REP 2016).
#include "ros/endpoints.hpp"
#include "ros_messages_description.hpp"
#include "vdrive/wire/ros_types.hpp"

#include <openssl/evp.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace vdrive::ros {
namespace {

/// The number of type_description_interfaces/msg/FieldType of a type that is no sequence.
template <typename Value>
constexpr int field_type() {
  if constexpr (wire::DescribedStruct<Value>) return 1;
  if constexpr (std::is_same_v<Value, std::uint8_t>) return 3;
  if constexpr (std::is_same_v<Value, std::int32_t>) return 6;
  if constexpr (std::is_same_v<Value, std::uint32_t>) return 7;
  if constexpr (std::is_same_v<Value, double>) return 11;
  if constexpr (std::is_same_v<Value, bool>) return 15;
  if constexpr (std::is_same_v<Value, std::byte>) return 16;
  if constexpr (std::is_same_v<Value, std::string>) return 17;
}

constexpr int kSequence = 144;  // of any length, added to the number of its elements

template <typename Value>
struct ElementOf {
  using Type = Value;
};

template <typename Element>
struct ElementOf<std::vector<Element>> {
  using Type = Element;
};

/// The descriptions of types by their names in ROS.
using Descriptions = std::map<std::string, std::string>;

/// @param used gets the descriptions of the types of the members
template <typename Message>
std::string description_of(Descriptions& used) {
  std::string json = R"({"type_name": ")" + ros_name<Message>() + R"(", "fields": [)";
  wire::for_each_member<Message>([&]<typename Value>(const wire::Member<Message, Value>& member) {
    using Element = typename ElementOf<Value>::Type;
    const int number = field_type<Element>() + (std::is_same_v<Element, Value> ? 0 : kSequence);
    std::string nested;
    if constexpr (wire::DescribedStruct<Element>) {
      nested = ros_name<Element>();
      used[nested] = description_of<Element>(used);
    }
    if (json.back() != '[') json += ", ";
    json += R"({"name": ")" + std::string(member.name) + R"(", "type": {"type_id": )" +
            std::to_string(number) +
            R"(, "capacity": 0, "string_capacity": 0, "nested_type_name": ")" + nested + R"("}})";
  });
  return json + "]}";
}

template <typename Message>
std::string whole_description() {
  Descriptions used;
  std::string json = R"({"type_description": )" + description_of<Message>(used) +
                     R"(, "referenced_type_descriptions": [)";
  for (const auto& [name, description] : used) {
    if (json.back() != '[') json += ", ";
    json += description;
  }
  return json + "]}";
}

template <typename... Message>
std::string description_named(std::string_view type) {
  std::string found;
  ((ros_name<Message>() == type ? void(found = whole_description<Message>()) : void()), ...);
  if (found.empty()) throw std::invalid_argument("no type " + std::string(type));
  return found;
}

}  // namespace

std::string type_description(std::string_view type) {
  return description_named<Time, Duration, Header, Bool, JointState, JointTrajectoryPoint,
                           JointTrajectory, KeyValue, DiagnosticStatus, DiagnosticArray, Clock,
                           Log>(type);
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
