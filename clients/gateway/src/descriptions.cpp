// SPDX-License-Identifier: Apache-2.0
#include "descriptions.hpp"

#include "channel.hpp"
#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/homing_method.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <utility>

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
    list.push_back({{"mode", static_cast<int>(row.mode)},
                    {"name", row.name},
                    {"commands_torque", row.commands_torque}});
  }
  return list;
}

Json error_code_json(ErrorCode code) {
  return {{"code", static_cast<std::uint16_t>(code)}, {"name", describe(code)}};
}

Json error_codes_json() {
  Json list = Json::array();
  list.push_back(error_code_json(ErrorCode::none));
  for (const ErrorCode code : error_codes()) list.push_back(error_code_json(code));
  return list;
}

// Some bits have different meanings in different modes, so each mode has a list.
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

Json homing_methods_json() {
  Json list = Json::array();
  for (const HomingMethodRow& method : kHomingMethods) {
    list.push_back({{"method", method.number},
                    {"direction", method.direction},
                    {"limit_switch", method.mark == HomingMark::limit_switch},
                    {"home_switch", method.mark == HomingMark::home_switch},
                    {"hard_stop", method.mark == HomingMark::hard_stop},
                    {"index_pulse", method.index}});
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

ChannelInfo description_channel(std::string topic) {
  const Json axis = object_schema(
      "axis:integer name:string topic:string unit:unit supported_drive_modes:integer "
      "user_position_lower_limit:integer user_position_upper_limit:integer "
      "app_speed_limit:integer",
      {{"unit", object_schema("kind:string name:string per:number")}});
  return json_channel(
      std::move(topic), "vdrive.BenchDescription",
      object_schema("bench:integer name:string clock_mode:string "
                    "period_us:integer dictionary_version:string "
                    "service_version:string host:string incarnation:string axes:axis[]",
                    {{"axis", axis}}));
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
                  {"host", info.host},
                  {"incarnation", session_text(info.incarnation)},
                  {"axes", std::move(axes)}});
}

ChannelInfo state_channel(std::string topic) {
  std::string members = "bench:integer tick:integer time_ns:string rate:number clock_mode:string ";
  for (const client::Figure& figure : client::all_figures()) {
    if (figure.is_headline) members.append(figure.name).append(":integer ");
  }
  members += "alive:boolean age_ms:integer owners:owner[] takings:taking[]";
  return json_channel(
      std::move(topic), "vdrive.BenchState",
      object_schema(members, {{"owner", object_schema("session:string name:string")},
                              {"taking", object_schema("axis:integer from:string by:string "
                                                       "tick:integer")}}));
}

std::string state_text(const client::BenchInfo& bench, std::uint64_t time,
                       std::chrono::milliseconds age, bool is_alive, const OwnerNames& names,
                       const std::vector<Taking>& takings) {
  Json owners = Json::array();
  for (const auto& [session, name] : names) {
    owners.push_back({{"session", session_text(session)}, {"name", to_string(name)}});
  }
  Json taken = Json::array();
  for (const Taking& taking : takings) {
    taken.push_back({{"axis", taking.axis},
                     {"from", session_text(taking.from)},
                     {"by", session_text(taking.by)},
                     {"tick", taking.tick}});
  }
  Json state{{"bench", bench.number},
             {"tick", bench.tick},
             {"time_ns", std::to_string(time)},  // exceeds the precision of a double
             {"rate", bench.rate},
             {"clock_mode", to_string(bench.clock_mode)},
             {"alive", is_alive},
             {"age_ms", age.count()},
             {"owners", std::move(owners)},
             {"takings", std::move(taken)}};
  for (const client::Figure& figure : bench.figures) {
    if (figure.is_headline) state[std::string(figure.name)] = figure.value;
  }
  return to_line(state);
}

ChannelInfo control_channel() {
  return json_channel("/gateway/control", "vdrive.Control",
                      object_schema("enabled:boolean holder:string you:boolean name:string "
                                    "session:string taken_at_ns:string silence_ms:integer"));
}

std::string control_text(const ControlState& control, const std::string& name, bool is_holder) {
  return to_line({{"enabled", control.is_enabled},
                  {"holder", control.holder},
                  {"you", is_holder},
                  {"name", name},
                  // As text: a double of JavaScript cannot hold 64 bits.
                  {"session", control.session == 0 ? "" : session_text(control.session)},
                  {"taken_at_ns", std::to_string(control.taken_at)},
                  {"silence_ms", control.silence.count()}});
}

ChannelInfo dictionary_channel() {
  const Json types{
      {"object", object_schema("index:string sub_index:integer name:string title:string "
                               "title_zh:string category:string type:string access:string "
                               "minimum:integer maximum:integer default:integer unit:string "
                               "storage:string effect:string")},
      {"mode", object_schema("mode:integer name:string commands_torque:boolean")},
      {"error", object_schema("code:integer name:string")},
      {"bits", object_schema("mode:integer bits:string[]")},
      {"homing_method", object_schema("method:integer direction:integer limit_switch:boolean "
                                      "home_switch:boolean hard_stop:boolean "
                                      "index_pulse:boolean")},
      {"disturbance", object_schema("name:string object:string kind:string minimum:integer "
                                    "maximum:integer")}};
  return json_channel("/gateway/dictionary", "vdrive.Dictionary",
                      object_schema("version:string objects:object[] modes:mode[] "
                                    "error_codes:error[] statusword_bits:bits[] "
                                    "controlword_bits:bits[] disturbances:disturbance[] "
                                    "homing_methods:homing_method[]",
                                    types));
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
                  {"disturbances", disturbances_json()},
                  {"homing_methods", homing_methods_json()}});
}

}  // namespace vdrive::gateway
