// SPDX-License-Identifier: Apache-2.0
#include "services.hpp"

#include "descriptions.hpp"
#include "directory.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace vdrive::gateway {
namespace {

using client::Axis;
using client::AxisGroup;
using client::Outcome;
using client::OutcomeKind;
using client::Result;
using client::Session;
using client::Until;
using namespace literals;

constexpr std::chrono::seconds kCallTime{10};  // drive time

// ---- requests

const Json& required(const Json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end()) throw ProtocolError("the key " + in_quotes(key) + " is missing");
  return *found;
}

std::int64_t integer_of(const Json& value, const char* key, std::int64_t lowest,
                        std::int64_t highest) {
  std::optional<std::int64_t> number;
  if (value.is_number_integer()) {
    number = value.get<std::int64_t>();
  } else if (value.is_number_float()) {
    // Forms of tools send 1.0; what is beside a whole number is rounded as the drive counts.
    const auto real = value.get<double>();
    constexpr double kExact = 9007199254740992.0;  // 2^53
    if (std::isfinite(real) && std::abs(real) <= kExact) number = std::llround(real);
  }
  if (number && *number >= lowest && *number <= highest) return *number;
  throw ProtocolError(in_quotes(key) + " must be a number from " + std::to_string(lowest) + " to " +
                      std::to_string(highest) + ", not " + in_quotes(value.dump()));
}

template <typename Number>
Number number_of(const Json& request, const char* key) {
  return static_cast<Number>(integer_of(required(request, key), key,
                                        std::numeric_limits<Number>::min(),
                                        std::numeric_limits<Number>::max()));
}

template <typename Number>
std::optional<Number> optional_number(const Json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end() || found->is_null()) return std::nullopt;
  return number_of<Number>(request, key);
}

double real_of(const Json& request, const char* key) {
  const Json& value = required(request, key);
  if (!value.is_number()) throw ProtocolError(in_quotes(key) + " must be a number");
  return value.get<double>();
}

std::string axis_text_of(const Json& request) {
  const Json& value = required(request, "axis");
  if (!value.is_string() || value.get_ref<const std::string&>().empty()) {
    throw ProtocolError(R"('axis' must be the address or the name of an axis, such as "1.2")");
  }
  return value.get<std::string>();
}

std::vector<std::string> axes_of(const Json& request) {
  const Json& list = required(request, "axes");
  if (!list.is_array() || list.empty()) {
    throw ProtocolError(R"('axes' must be a list of addresses or names, such as ["1.1", "1.2"])");
  }
  std::vector<std::string> axes;
  axes.reserve(list.size());
  for (const Json& axis : list) {
    if (!axis.is_string()) throw ProtocolError(R"('axes' must have texts, such as "1.2")");
    axes.push_back(axis.get<std::string>());
  }
  return axes;
}

ObjectAddress object_of(const Json& value) {
  std::optional<ObjectAddress> object;
  if (value.is_string()) object = parse_object(value.get_ref<const std::string&>());
  if (!object || !find_object(*object)) {
    throw ProtocolError(in_quotes(value.dump()) +
                        R"( is not an object: expected such as "0x6081", "0x607D:01" or )"
                        R"("profile_velocity")");
  }
  return *object;
}

client::CallOptions options(Until until) {
  return {.timeout = kCallTime, .until = until};
}

CallAnswer with_tick(const Result<std::uint64_t>& result) {
  if (!result) return {.outcome = result.outcome()};
  return {.outcome = {}, .fields = {{"tick", *result}}};
}

// ---- axes

Result<std::vector<Axis>> find_axes(Session& session, const std::vector<std::string>& names) {
  std::vector<Axis> axes;
  axes.reserve(names.size());
  for (const std::string& name : names) {
    auto axis = session.axis(name);
    if (!axis) return axis.outcome();
    axes.push_back(std::move(*axis));
  }
  return axes;
}

/// Axes that one group can have: of one bench each.
std::vector<std::vector<Axis>> by_bench(const std::vector<Axis>& axes) {
  std::map<std::uint32_t, std::vector<std::vector<Axis>>> parts;
  for (const Axis& axis : axes) {
    auto& of_bench = parts[axis.id().bench];
    if (of_bench.empty() || of_bench.back().size() == client::kMostAxesAtOnce)
      of_bench.emplace_back();
    of_bench.back().push_back(axis);
  }
  std::vector<std::vector<Axis>> groups;
  for (auto& [bench, of_bench] : parts) {
    for (auto& part : of_bench) groups.push_back(std::move(part));
  }
  return groups;
}

using OneAxis = Outcome (*)(Axis& axis);
using AllAxes = Outcome (*)(AxisGroup& group);

Outcome for_each_axis(std::vector<Axis>& axes, OneAxis one) {
  for (Axis& axis : axes) {
    if (Outcome outcome = one(axis); !outcome) return outcome;
  }
  return {};
}

Outcome for_group(Session& session, const std::vector<Axis>& axes, AllAxes all) {
  auto group = AxisGroup::create(session, axes);
  return group ? all(*group) : group.outcome();
}

/// Several axes at once where the library can, so that they act on one tick.
CallAnswer for_axes(Session& session, const Json& request, OneAxis one, AllAxes all) {
  auto axes = find_axes(session, axes_of(request));
  if (!axes) return {.outcome = axes.outcome()};
  for (auto& part : by_bench(*axes)) {
    const bool is_group = part.size() > 1 && all != nullptr;
    Outcome outcome = is_group ? for_group(session, part, all) : for_each_axis(part, one);
    if (!outcome) return {.outcome = std::move(outcome)};
  }
  return {};
}

client::GroupCallOptions group_options(Until until) {
  return {.timeout = kCallTime, .until = until, .progress = {}};
}

CallAnswer call_enable(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.enable(options(Until::done));
      },
      [](AxisGroup& group) {
        return group.enable_all(group_options(Until::done));
      });
}

CallAnswer call_disable(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.disable(options(Until::done));
      },
      [](AxisGroup& group) {
        return group.disable_all(group_options(Until::done));
      });
}

CallAnswer call_halt(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.halt(options(Until::in_force));
      },
      [](AxisGroup& group) {
        return group.halt_all(group_options(Until::in_force));
      });
}

CallAnswer call_resume(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.resume(options(Until::in_force));
      },
      [](AxisGroup& group) {
        return group.resume_all(group_options(Until::in_force));
      });
}

CallAnswer call_reset(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.reset_fault(options(Until::done));
      },
      [](AxisGroup& group) {
        return group.reset_all(group_options(Until::done));
      });
}

CallAnswer call_power_cycle(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.power_cycle(options(Until::done));
      },
      nullptr);
}

CallAnswer call_store(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.store();
      },
      nullptr);
}

CallAnswer call_restore(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.restore_defaults();
      },
      nullptr);
}

CallAnswer call_end_disturbances(Session& session, const Json& request) {
  return for_axes(
      session, request,
      [](Axis& axis) {
        return axis.end_disturbances();
      },
      nullptr);
}

/// Axes, a bench, or every bench: the rest of them also when one of them cannot be stopped.
CallAnswer call_quick_stop(Session& session, const Json& request) {
  if (request.contains("axes")) {
    return for_axes(
        session, request,
        [](Axis& axis) {
          return axis.quick_stop(options(Until::in_force));
        },
        [](AxisGroup& group) {
          return group.quick_stop_all(group_options(Until::in_force));
        });
  }
  std::vector<std::uint32_t> benches;
  if (request.contains("bench")) {
    benches.push_back(number_of<std::uint32_t>(request, "bench"));
  } else {
    for (const client::BenchInfo& bench : session.find_benches()) benches.push_back(bench.number);
    if (benches.empty()) return {.outcome = session.no_bench_found()};
  }
  CallAnswer answer;
  for (const std::uint32_t bench : benches) {
    Outcome outcome = session.quick_stop(bench, options(Until::in_force));
    if (!outcome && answer.outcome) answer.outcome = std::move(outcome);
  }
  return answer;
}

// ---- motion

CallAnswer call_move(Session& session, const Json& request) {
  const std::string name = axis_text_of(request);
  const auto position = number_of<std::int32_t>(request, "position");
  const client::MoveOptions move{
      .velocity = optional_number<std::uint32_t>(request, "velocity"),
      .acceleration = optional_number<std::uint32_t>(request, "acceleration"),
      .deceleration = optional_number<std::uint32_t>(request, "deceleration"),
      .queue = flag_of(request, "queue"),
      .call = options(Until::in_force)};
  const bool is_relative = flag_of(request, "relative");
  auto axis = session.axis(name);
  if (!axis) return {.outcome = axis.outcome()};
  return {.outcome = is_relative ? axis->move_by(position, move) : axis->move_to(position, move)};
}

struct LimitRow {
  const char* key = "";
  ObjectAddress object;
};

constexpr std::array kMoveLimits{
    LimitRow{"velocity", vdrive::describe("profile_velocity"_object).address},
    LimitRow{"acceleration", vdrive::describe("profile_acc"_object).address},
    LimitRow{"deceleration", vdrive::describe("profile_dec"_object).address},
};

Outcome write_limits(std::vector<Axis>& axes, const Json& request) {
  for (const LimitRow& limit : kMoveLimits) {
    const auto value = optional_number<std::uint32_t>(request, limit.key);
    if (!value) continue;
    for (Axis& axis : axes) {
      if (const auto written = axis.write(limit.object, *value); !written) return written.outcome();
    }
  }
  return {};
}

CallAnswer call_move_group(Session& session, const Json& request) {
  const Json& moves = required(request, "moves");
  if (!moves.is_array() || moves.empty()) {
    throw ProtocolError(R"('moves' must be a list such as [{"axis": "1.1", "position": 0}])");
  }
  std::vector<std::string> names;
  names.reserve(moves.size());
  Eigen::VectorXd targets(static_cast<Eigen::Index>(moves.size()));
  for (const Json& move : moves) {
    if (!move.is_object()) throw ProtocolError("'moves' must have objects");
    targets[static_cast<Eigen::Index>(names.size())] = number_of<std::int32_t>(move, "position");
    names.push_back(axis_text_of(move));
  }
  auto axes = find_axes(session, names);
  if (!axes) return {.outcome = axes.outcome()};
  if (Outcome outcome = write_limits(*axes, request); !outcome) return {.outcome = outcome};
  auto group = AxisGroup::create(session, *axes);
  if (!group) return {.outcome = group.outcome()};
  client::GroupMoveOptions move;
  move.call.until = Until::in_force;
  return {.outcome = group->move_together(targets, move)};
}

CallAnswer call_home(Session& session, const Json& request) {
  auto axis = session.axis(axis_text_of(request));
  if (!axis) return {.outcome = axis.outcome()};
  client::HomingOptions homing;
  homing.call = options(Until::in_force);
  return {.outcome = axis->home(homing)};
}

// ---- bench

CallAnswer call_disturb(Session& session, const Json& request) {
  const std::string name = text_of(request, "name");
  const auto* const row =
      std::ranges::find(client::kDisturbances, name, &client::DisturbanceRow::name);
  if (row == client::kDisturbances.end()) {
    throw ProtocolError("the disturbance " + in_quotes(name) + " does not exist");
  }
  const auto value = number_of<std::int32_t>(request, "value");
  auto axis = session.axis(axis_text_of(request));
  if (!axis) return {.outcome = axis.outcome()};
  return with_tick(axis->disturb(row->disturbance, value));
}

CallAnswer call_pause(Session& session, const Json& request) {
  return with_tick(session.set_rate(number_of<std::uint32_t>(request, "bench"), 0.0));
}

CallAnswer call_rate(Session& session, const Json& request) {
  return with_tick(
      session.set_rate(number_of<std::uint32_t>(request, "bench"), real_of(request, "rate")));
}

CallAnswer call_step(Session& session, const Json& request) {
  constexpr std::int64_t kMostTicks = 1'000'000;
  const auto ticks = integer_of(required(request, "ticks"), "ticks", 1, kMostTicks);
  return with_tick(
      session.step(number_of<std::uint32_t>(request, "bench"), static_cast<std::uint64_t>(ticks)));
}

// ---- objects

CallAnswer call_read(Session& session, const Json& request) {
  const Json& list = required(request, "objects");
  if (!list.is_array() || list.empty() || list.size() > client::kMostObjectsAtOnce) {
    throw ProtocolError("'objects' must be a list of 1 to " +
                        std::to_string(client::kMostObjectsAtOnce) +
                        R"( objects, such as ["0x6081"])");
  }
  std::vector<ObjectAddress> objects;
  objects.reserve(list.size());
  for (const Json& object : list) objects.push_back(object_of(object));
  const auto axis = session.axis(axis_text_of(request));
  if (!axis) return {.outcome = axis.outcome()};
  const auto readings = axis->read(objects);
  if (!readings) return {.outcome = readings.outcome()};
  Json values = Json::array();
  for (const client::ObjectReading& reading : readings->objects) {
    Json value{{"object", object_key(reading.object)},
               {"code", wire_code(reading.code)},
               {"message", reading.code == AbortCode::none ? "" : vdrive::describe(reading.code)}};
    if (reading.code == AbortCode::none) value["value"] = reading.value;
    values.push_back(std::move(value));
  }
  return {.outcome = {}, .fields = {{"tick", readings->tick}, {"values", std::move(values)}}};
}

CallAnswer call_write(Session& session, const Json& request) {
  const ObjectAddress object = object_of(required(request, "object"));
  const std::int64_t value =
      integer_of(required(request, "value"), "value", std::numeric_limits<std::int64_t>::min(),
                 std::numeric_limits<std::int64_t>::max());
  auto axis = session.axis(axis_text_of(request));
  if (!axis) return {.outcome = axis.outcome()};
  return with_tick(axis->write(object, value));
}

// ---- schemas

Json axes_request() {
  return object_schema({{"axes", array_schema(text_schema())}});
}

Json stop_request() {
  return object_schema({{"axes?", array_schema(text_schema())}, {"bench?", integer_schema()}});
}

Json take_request() {
  return object_schema({{"name?", text_schema()}, {"force?", boolean_schema()}});
}

Json empty_request() {
  return object_schema({});
}

Json move_request() {
  return object_schema({{"axis", text_schema()},
                        {"position", integer_schema()},
                        {"relative?", boolean_schema()},
                        {"velocity?", integer_schema()},
                        {"acceleration?", integer_schema()},
                        {"deceleration?", integer_schema()},
                        {"queue?", boolean_schema()}});
}

Json move_group_request() {
  return object_schema({{"moves", array_schema(object_schema(
                                      {{"axis", text_schema()}, {"position", integer_schema()}}))},
                        {"velocity?", integer_schema()},
                        {"acceleration?", integer_schema()},
                        {"deceleration?", integer_schema()}});
}

Json axis_request() {
  return object_schema({{"axis", text_schema()}});
}

Json jog_request() {
  return object_schema({{"axis", text_schema()}, {"velocity", integer_schema()}});
}

Json disturb_request() {
  return object_schema(
      {{"axis", text_schema()}, {"name", text_schema()}, {"value", integer_schema()}});
}

Json bench_request() {
  return object_schema({{"bench", integer_schema()}});
}

Json rate_request() {
  return object_schema({{"bench", integer_schema()}, {"rate", number_schema()}});
}

Json step_request() {
  return object_schema({{"bench", integer_schema()}, {"ticks", integer_schema()}});
}

Json read_request() {
  return object_schema({{"axis", text_schema()}, {"objects", array_schema(text_schema())}});
}

Json write_request() {
  return object_schema(
      {{"axis", text_schema()}, {"object", text_schema()}, {"value", integer_schema()}});
}

Json response_schema(Right right) {
  Json schema = object_schema({{"ok", boolean_schema()},
                               {"outcome", text_schema()},
                               {"message", text_schema()},
                               {"code", integer_schema()},
                               {"tick?", integer_schema()}});
  if (right == Right::none) {
    schema["properties"]["values"] = array_schema(object_schema({{"object", text_schema()},
                                                                 {"value?", integer_schema()},
                                                                 {"code", integer_schema()},
                                                                 {"message", text_schema()}}));
  }
  return schema;
}

constexpr std::array kServices{
    ServiceRow{"/take_control", "vdrive.TakeControl", Right::change_control, take_request, nullptr},
    ServiceRow{"/release_control", "vdrive.ReleaseControl", Right::change_control, empty_request,
               nullptr},
    ServiceRow{"/enable", "vdrive.Enable", Right::command, axes_request, call_enable},
    ServiceRow{"/disable", "vdrive.Disable", Right::command, axes_request, call_disable},
    ServiceRow{"/halt", "vdrive.Halt", Right::stop, axes_request, call_halt},
    ServiceRow{"/resume", "vdrive.Resume", Right::command, axes_request, call_resume},
    ServiceRow{"/quick_stop", "vdrive.QuickStop", Right::stop, stop_request, call_quick_stop},
    ServiceRow{"/reset", "vdrive.Reset", Right::command, axes_request, call_reset},
    ServiceRow{"/move", "vdrive.Move", Right::command, move_request, call_move},
    ServiceRow{"/move_group", "vdrive.MoveGroup", Right::command, move_group_request,
               call_move_group},
    ServiceRow{"/home", "vdrive.Home", Right::command, axis_request, call_home},
    ServiceRow{"/jog", "vdrive.Jog", Right::jog, jog_request, nullptr},
    ServiceRow{"/disturb", "vdrive.Disturb", Right::command, disturb_request, call_disturb},
    ServiceRow{"/end_disturbances", "vdrive.EndDisturbances", Right::command, axes_request,
               call_end_disturbances},
    ServiceRow{"/store", "vdrive.Store", Right::command, axes_request, call_store},
    ServiceRow{"/restore", "vdrive.Restore", Right::command, axes_request, call_restore},
    ServiceRow{"/power_cycle", "vdrive.PowerCycle", Right::command, axes_request, call_power_cycle},
    ServiceRow{"/pause", "vdrive.Pause", Right::command, bench_request, call_pause},
    ServiceRow{"/rate", "vdrive.Rate", Right::command, rate_request, call_rate},
    ServiceRow{"/step", "vdrive.Step", Right::command, step_request, call_step},
    ServiceRow{"/read", "vdrive.Read", Right::none, read_request, call_read},
    ServiceRow{"/write", "vdrive.Write", Right::command, write_request, call_write},
};

}  // namespace

std::span<const ServiceRow> services() {
  return kServices;
}

std::vector<ServiceInfo> service_infos() {
  std::vector<ServiceInfo> infos;
  infos.reserve(kServices.size());
  for (const ServiceRow& row : kServices) {
    infos.push_back({.id = static_cast<std::uint32_t>(infos.size() + 1),
                     .name = std::string(row.name),
                     .type = std::string(row.type),
                     .request_schema = row.request_schema(),
                     .response_schema = response_schema(row.right)});
  }
  return infos;
}

std::string answer_text(const CallAnswer& answer) {
  Json json = answer.fields;
  json["ok"] = static_cast<bool>(answer.outcome);
  json["outcome"] = to_string(answer.outcome.kind());
  json["message"] = answer.outcome.message();
  json["code"] = answer.outcome.code();
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string text_of(const Json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end() || found->is_null()) return {};
  if (!found->is_string()) throw ProtocolError(in_quotes(key) + " must be a text");
  return found->get<std::string>();
}

bool flag_of(const Json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end() || found->is_null()) return false;
  if (!found->is_boolean()) throw ProtocolError(in_quotes(key) + " must be true or false");
  return found->get<bool>();
}

JogRequest jog_of(const Json& request) {
  return {.axis = axis_text_of(request), .velocity = number_of<std::int32_t>(request, "velocity")};
}

client::VelocityOptions jog_options() {
  client::VelocityOptions jog;
  jog.call = options(Until::done);
  return jog;
}

}  // namespace vdrive::gateway
