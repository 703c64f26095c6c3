// SPDX-License-Identifier: Apache-2.0
#include "descriptions.hpp"

#include "channel.hpp"
#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

#include <limits>

namespace vdrive::gateway {
namespace {

constexpr std::size_t kBitsOfWord = 16;

ChannelInfo json_channel(std::string topic, std::string type, const Json& schema) {
  return {.id = next_channel_id(),
          .topic = std::move(topic),
          .encoding = "json",
          .schema_name = std::move(type),
          .schema = to_line(schema),
          .schema_encoding = "jsonschema"};
}

Json unit_json(const Unit& unit) {
  return {{"kind", to_string(unit.kind)}, {"name", unit.name}, {"per", unit.size}};
}

Json object_json(const ObjectDescription& row) {
  return {{"index", hex(row.address.index, 4)},
          {"sub_index", row.address.subindex},
          {"name", row.variable_name},
          {"title", row.name},
          {"title_zh", row.name_zh},
          {"category", row.category},
          {"type", to_string(row.data_type)},
          {"access", to_string(row.access)},
          {"minimum", row.lower_limit},
          {"maximum", row.upper_limit},
          {"default", row.default_value},
          {"unit", english_units(row)},
          {"storage", row.storage == Storage::flash ? "flash" : "none"},
          {"effect", to_string(row.effective)}};
}

Json modes_json() {
  Json list = Json::array();
  for (const OperatingModeRow& row : kOperatingModes) {
    list.push_back({{"mode", static_cast<int>(row.mode)}, {"name", row.name}});
  }
  return list;
}

Json error_codes_json() {
  const std::string_view unknown = describe(static_cast<ErrorCode>(1));
  Json list = Json::array();
  for (std::uint32_t code = 0; code <= std::numeric_limits<std::uint16_t>::max(); ++code) {
    const std::string_view name = describe(static_cast<ErrorCode>(code));
    if (name != unknown) list.push_back({{"code", code}, {"name", name}});
  }
  return list;
}

using NameOfBit = std::string_view (*)(std::uint16_t bit, OperatingMode mode);

Json bits_json(NameOfBit name_of) {
  Json list = Json::array();
  for (const OperatingModeRow& row : kOperatingModes) {
    Json names = Json::array();
    for (std::size_t bit = 0; bit < kBitsOfWord; ++bit) {
      names.push_back(name_of(static_cast<std::uint16_t>(1U << bit), row.mode));
    }
    list.push_back({{"mode", static_cast<int>(row.mode)}, {"bits", std::move(names)}});
  }
  return list;
}

Json disturbances_json() {
  Json list = Json::array();
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    const ObjectDescription& object = describe(*find_object(row.variable_name));
    const bool is_switch = object.lower_limit == 0 && object.upper_limit == 1;
    list.push_back({{"name", row.name},
                    {"object", object_key(object.address)},
                    {"kind", is_switch ? "switch" : "value"},
                    {"minimum", object.lower_limit},
                    {"maximum", object.upper_limit}});
  }
  return list;
}

}  // namespace

Json text_schema() {
  return {{"type", "string"}};
}

Json integer_schema() {
  return {{"type", "integer"}};
}

Json number_schema() {
  return {{"type", "number"}};
}

Json boolean_schema() {
  return {{"type", "boolean"}};
}

Json array_schema(Json items) {
  return {{"type", "array"}, {"items", std::move(items)}};
}

Json object_schema(std::initializer_list<std::pair<std::string_view, Json>> properties) {
  Json described = Json::object();
  Json required = Json::array();
  for (const auto& [key, schema] : properties) {
    std::string name(key);
    if (name.ends_with('?')) {
      name.pop_back();
    } else {
      required.push_back(name);
    }
    described[name] = schema;
  }
  return {
      {"type", "object"}, {"properties", std::move(described)}, {"required", std::move(required)}};
}

ChannelInfo description_channel(std::string topic) {
  const Json unit =
      object_schema({{"kind", text_schema()}, {"name", text_schema()}, {"per", number_schema()}});
  const Json axis = object_schema({{"axis", integer_schema()},
                                   {"name", text_schema()},
                                   {"topic", text_schema()},
                                   {"unit", unit},
                                   {"supported_drive_modes", integer_schema()},
                                   {"user_position_lower_limit", integer_schema()},
                                   {"user_position_upper_limit", integer_schema()},
                                   {"app_speed_limit", integer_schema()}});
  return json_channel(std::move(topic), "vdrive.BenchDescription",
                      object_schema({{"bench", integer_schema()},
                                     {"name", text_schema()},
                                     {"clock_mode", text_schema()},
                                     {"period_us", integer_schema()},
                                     {"dictionary_version", text_schema()},
                                     {"service_version", text_schema()},
                                     {"incarnation", text_schema()},
                                     {"axes", array_schema(axis)}}));
}

std::string description_text(const KnownBench& bench) {
  const client::BenchInfo& info = bench.info;
  Json axes = Json::array();
  for (std::size_t i = 0; i < info.axes.size(); ++i) {
    const client::AxisInfo& axis = info.axes[i];
    axes.push_back({{"axis", axis.id.axis},
                    {"name", axis.name},
                    {"topic", bench.axis_names[i]},
                    {"unit", unit_json(axis.unit)},
                    {"supported_drive_modes", axis.supported_drive_modes},
                    {"user_position_lower_limit", axis.user_position_lower_limit},
                    {"user_position_upper_limit", axis.user_position_upper_limit},
                    {"app_speed_limit", axis.app_speed_limit}});
  }
  return to_line({{"bench", info.number},
                  {"name", info.name},
                  {"clock_mode", to_string(info.clock_mode)},
                  {"period_us", info.period.count()},
                  {"dictionary_version", info.dictionary_version},
                  {"service_version", info.service_version},
                  {"incarnation", session_text(info.incarnation)},
                  {"axes", std::move(axes)}});
}

ChannelInfo state_channel(std::string topic) {
  return json_channel(std::move(topic), "vdrive.BenchState",
                      object_schema({{"bench", integer_schema()},
                                     {"tick", integer_schema()},
                                     {"time_ns", text_schema()},
                                     {"rate", number_schema()},
                                     {"clock_mode", text_schema()},
                                     {"wire_starts", integer_schema()},
                                     {"longest_silence_us", integer_schema()},
                                     {"alive", boolean_schema()},
                                     {"age_ms", integer_schema()}}));
}

std::string state_text(const client::BenchInfo& bench, std::uint64_t time,
                       std::chrono::milliseconds age, bool is_alive) {
  return to_line({{"bench", bench.number},
                  {"tick", bench.tick},
                  {"time_ns", std::to_string(time)},  // beyond what a double holds
                  {"rate", bench.rate},
                  {"clock_mode", to_string(bench.clock_mode)},
                  {"wire_starts", bench.wire_starts},
                  {"longest_silence_us", bench.longest_silence.count()},
                  {"alive", is_alive},
                  {"age_ms", age.count()}});
}

ChannelInfo control_channel() {
  return json_channel("/gateway/control", "vdrive.Control",
                      object_schema({{"enabled", boolean_schema()},
                                     {"holder", text_schema()},
                                     {"you", boolean_schema()},
                                     {"name", text_schema()},
                                     {"session", text_schema()},
                                     {"taken_at_ns", text_schema()}}));
}

std::string control_text(const ControlState& control, const std::string& name, bool is_holder) {
  return to_line({{"enabled", control.is_enabled},
                  {"holder", control.holder},
                  {"you", is_holder},
                  {"name", name},
                  {"session", control.session == 0 ? "" : session_text(control.session)},
                  {"taken_at_ns", std::to_string(control.taken_at)}});
}

ChannelInfo dictionary_channel() {
  const Json object = object_schema({{"index", text_schema()},
                                     {"sub_index", integer_schema()},
                                     {"name", text_schema()},
                                     {"title", text_schema()},
                                     {"title_zh", text_schema()},
                                     {"category", text_schema()},
                                     {"type", text_schema()},
                                     {"access", text_schema()},
                                     {"minimum", integer_schema()},
                                     {"maximum", integer_schema()},
                                     {"default", integer_schema()},
                                     {"unit", text_schema()},
                                     {"storage", text_schema()},
                                     {"effect", text_schema()}});
  const Json mode = object_schema({{"mode", integer_schema()}, {"name", text_schema()}});
  const Json error = object_schema({{"code", integer_schema()}, {"name", text_schema()}});
  const Json bits =
      object_schema({{"mode", integer_schema()}, {"bits", array_schema(text_schema())}});
  const Json disturbance = object_schema({{"name", text_schema()},
                                          {"object", text_schema()},
                                          {"kind", text_schema()},
                                          {"minimum", integer_schema()},
                                          {"maximum", integer_schema()}});
  return json_channel("/gateway/dictionary", "vdrive.Dictionary",
                      object_schema({{"version", text_schema()},
                                     {"objects", array_schema(object)},
                                     {"modes", array_schema(mode)},
                                     {"error_codes", array_schema(error)},
                                     {"statusword_bits", array_schema(bits)},
                                     {"controlword_bits", array_schema(bits)},
                                     {"disturbances", array_schema(disturbance)}}));
}

std::string dictionary_text() {
  Json objects = Json::array();
  for (const ObjectDescription& row : kObjectTable) objects.push_back(object_json(row));
  return to_line({{"version", kDictionaryVersion},
                  {"objects", std::move(objects)},
                  {"modes", modes_json()},
                  {"error_codes", error_codes_json()},
                  {"statusword_bits", bits_json(statusword_bit_name)},
                  {"controlword_bits", bits_json(controlword_bit_name)},
                  {"disturbances", disturbances_json()}});
}

}  // namespace vdrive::gateway
