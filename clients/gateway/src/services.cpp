// SPDX-License-Identifier: Apache-2.0
#include "services.hpp"

#include "directory.hpp"
#include "fault_calls.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace vdrive::gateway {
namespace {

using client::Axis;
using client::AxisGroup;
using client::EachCommand;
using client::Outcome;
using client::OutcomeKind;
using client::Result;
using client::Session;
using client::Until;
using namespace literals;

// Drive time. A person waits for the answer; longer actions, such as a move to a target, are only
// awaited until they are in force.
constexpr std::chrono::seconds kCallTime{10};

// ---- requests

std::int64_t integer_of(const Json& request, const char* key, const NumberRange& range) {
  const Json& value = member(request, key);
  std::optional<std::int64_t> number;
  if (value.is_number_integer()) {
    number = value.get<std::int64_t>();
  } else if (value.is_number_float()) {
    // Tools' forms send 1.0; fractions are rounded to the units that the drive counts.
    const auto real = value.get<double>();
    if (std::isfinite(real) && std::abs(real) <= kLargestExact) number = std::llround(real);
  }
  if (number && *number >= range.lowest && *number <= range.highest) return *number;
  throw ProtocolError(in_quotes(key) + " must be a number from " + std::to_string(range.lowest) +
                      " to " + std::to_string(range.highest) + ", not " + in_quotes(value.dump()));
}

template <typename Number>
Number number_of(const Json& request, const char* key) {
  using Limits = std::numeric_limits<Number>;
  return static_cast<Number>(
      integer_of(request, key, {.lowest = Limits::min(), .highest = Limits::max()}));
}

template <typename Number>
std::optional<Number> optional_number(const Json& request, const char* key) {
  if (is_absent(request, key)) return std::nullopt;
  return number_of<Number>(request, key);
}

std::string axis_text_of(const Json& request) {
  const Json& value = member(request, "axis");
  if (!value.is_string() || value.get_ref<const std::string&>().empty()) {
    throw ProtocolError(R"('axis' must be the address or the name of an axis, such as "1.2")");
  }
  return value.get<std::string>();
}

std::vector<std::string> axes_of(const Json& request) {
  const Json& list = member(request, "axes");
  if (!list.is_array() || list.empty()) {
    throw ProtocolError(R"('axes' must be a list of addresses or names, such as ["1.1", "1.2"])");
  }
  return each_of(list, [](const Json& axis) {
    if (!axis.is_string()) throw ProtocolError(R"('axes' must contain strings, such as "1.2")");
    return axis.get<std::string>();
  });
}

ObjectAddress object_of(const Json& value) {
  std::optional<ObjectAddress> object;
  if (value.is_string()) object = parse_object(value.get_ref<const std::string&>());
  if (!object || !find_object(*object)) {
    throw ProtocolError(in_quotes(value.dump()) +
                        R"( is not an object: write it like "0x6081", "0x607D:01" or )"
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

/// Splits axes into parts that can be one group: of one bench, and no more than fit into a frame.
std::vector<std::vector<Axis>> by_bench(std::vector<Axis> axes) {
  // Stable: axes of a bench are commanded in the order of the request.
  std::ranges::stable_sort(axes, {}, [](const Axis& axis) {
    return axis.id().bench;
  });
  std::vector<std::vector<Axis>> groups;
  for (Axis& axis : axes) {
    const bool has_place = !groups.empty() && groups.back().size() < client::kMostAxesAtOnce &&
                           groups.back().front().id().bench == axis.id().bench;
    if (!has_place) groups.emplace_back();
    groups.back().push_back(std::move(axis));
  }
  return groups;
}

/// Applies the service to axes of one bench.
Outcome command_axes(Session& session, std::vector<Axis>& axes, const AxesService& service) {
  if (!service.command) {
    Outcome outcome;
    for (auto axis = axes.begin(); outcome && axis != axes.end(); ++axis) {
      outcome = ((*axis).*service.each)();
    }
    return outcome;
  }
  // A power cycle is not commanded as a group: a group would then wait for the status of its axes
  // after a later tick, and a paused bench has no later tick.
  if (axes.size() == 1 || service.command == EachCommand::power_cycle) {
    for (Outcome& outcome : session.command_each(axes, *service.command, options(service.until))) {
      if (!outcome) return std::move(outcome);
    }
    return {};
  }
  auto group = AxisGroup::create(session, axes);
  if (!group) return group.outcome();
  return group->command(*service.command,
                        {.timeout = kCallTime, .until = service.until, .progress = {}});
}

CallAnswer call_axes(Session& session, const Json& request, const AxesService& service) {
  auto axes = find_axes(session, axes_of(request));
  if (!axes) return {.outcome = axes.outcome()};
  for (std::vector<Axis>& part : by_bench(std::move(*axes))) {
    if (Outcome outcome = command_axes(session, part, service); !outcome) {
      return {.outcome = std::move(outcome)};
    }
  }
  return {};
}

/// Stops axes, a bench, or every bench; if one of them cannot be stopped, the others still are.
CallAnswer call_quick_stop(Session& session, const Json& request) {
  constexpr Until kUntil = Until::in_force;
  if (request.contains("axes")) {
    return call_axes(session, request, {.command = EachCommand::quick_stop, .until = kUntil});
  }
  std::vector<std::uint32_t> benches;
  if (request.contains("bench")) {
    benches.push_back(number_of<std::uint32_t>(request, "bench"));
  } else {
    for (const client::BenchInfo& bench : session.find_benches()) benches.push_back(bench.number);
    if (benches.empty()) return {.outcome = session.no_bench_found()};
  }
  // The first failure is the answer; the other benches are stopped nevertheless.
  CallAnswer answer;
  for (const std::uint32_t bench : benches) {
    Outcome outcome = session.quick_stop(bench, options(kUntil));
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
    LimitRow{"velocity", kObjectRows["profile_velocity"_object].address},
    LimitRow{"acceleration", kObjectRows["profile_acc"_object].address},
    LimitRow{"deceleration", kObjectRows["profile_dec"_object].address},
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

/// The drive limits a written 6081h to 607Fh silently; a value in a call must be valid as given.
Outcome check_velocity(const std::vector<Axis>& axes, const Json& request) {
  const auto velocity = optional_number<std::uint32_t>(request, "velocity");
  if (!velocity) return {};
  for (const Axis& axis : axes) {
    if (Outcome good = axis.check_velocity_limits(*velocity); !good) return good;
  }
  return {};
}

CallAnswer call_move_group(Session& session, const Json& request) {
  const Json& moves = member(request, "moves");
  if (!moves.is_array() || moves.empty()) {
    throw ProtocolError(R"('moves' must be a list such as [{"axis": "1.1", "position": 0}])");
  }
  Eigen::VectorXd targets(static_cast<Eigen::Index>(moves.size()));
  Eigen::Index place = 0;
  const auto names = each_of(moves, [&](const Json& move) {
    if (!move.is_object()) throw ProtocolError("'moves' must contain objects");
    targets[place++] = number_of<std::int32_t>(move, "position");
    return axis_text_of(move);
  });
  auto axes = find_axes(session, names);
  if (!axes) return {.outcome = axes.outcome()};
  if (Outcome good = check_velocity(*axes, request); !good) return {.outcome = good};
  // The limits remain in the drives after the move: the group moves each axis within its own.
  if (Outcome outcome = write_limits(*axes, request); !outcome) return {.outcome = outcome};
  auto group = AxisGroup::create(session, *axes);
  if (!group) return {.outcome = group.outcome()};
  // No time limit here: the library gives a group the duration of its move plus 5 s.
  client::GroupMoveOptions move;
  move.call.until = Until::in_force;
  return {.outcome = group->move_together(targets, move)};
}

CallAnswer call_home(Session& session, const Json& request) {
  client::HomingOptions homing;
  homing.method = optional_number<std::int8_t>(request, "method");
  homing.call = options(Until::in_force);
  auto axis = session.axis(axis_text_of(request));
  if (!axis) return {.outcome = axis.outcome()};
  return {.outcome = axis->home(homing)};
}

// ---- bench

CallAnswer call_disturb(Session& session, const Json& request) {
  const std::string name = optional_text(request, "name").value_or("");
  // Checked before the search for the axis, so that a wrong name is refused without a wait.
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
  const auto bench = number_of<std::uint32_t>(request, "bench");
  const Json& rate = member(request, "rate");
  if (!rate.is_number()) throw ProtocolError("'rate' must be a number");
  return with_tick(session.set_rate(bench, rate.get<double>()));
}

CallAnswer call_step(Session& session, const Json& request) {
  constexpr std::int64_t kMostTicks = 1'000'000;  // limit of the service for one request
  const auto ticks = static_cast<std::uint64_t>(
      integer_of(request, "ticks", {.lowest = 1, .highest = kMostTicks}));
  return with_tick(session.step(number_of<std::uint32_t>(request, "bench"), ticks));
}

// ---- objects

CallAnswer call_read(Session& session, const Json& request) {
  const Json& list = member(request, "objects");
  if (!list.is_array() || list.empty() || list.size() > client::kMostObjectsAtOnce) {
    throw ProtocolError("'objects' must be a list of 1 to " +
                        std::to_string(client::kMostObjectsAtOnce) +
                        R"( objects, such as ["0x6081"])");
  }
  const auto objects = each_of(list, object_of);
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
  const ObjectAddress object = object_of(member(request, "object"));
  const auto value = number_of<std::int64_t>(request, "value");
  auto axis = session.axis(axis_text_of(request));
  if (!axis) return {.outcome = axis.outcome()};
  return with_tick(axis->write(object, value));
}

// ---- the table

Json response_schema(const ServiceRow& row) {
  const Right right = row.right;
  std::string members = "ok:boolean outcome:string message:string code:integer tick?:integer";
  if (right == Right::events) {
    const Json event = object_schema(
        "tick:integer axis:integer kind:string level:integer code:integer message:string");
    return object_schema(members + " events?:event[]", {{"event", event}});
  }
  if (right == Right::judge) {
    const Json finding = object_schema(
        "rule:string severity:string title:string axis:integer count:integer tick:integer "
        "happened:string expected:string remedy:string");
    return object_schema(members + " judged?:boolean findings?:finding[]", {{"finding", finding}});
  }
  if (row.call == call_freeze) return object_schema(members + " window?:integer");
  if (right != Right::none) return object_schema(members);
  const Json window = object_schema(
      "window:integer first_tick:integer last_tick:integer "
      "is_open:boolean more_causes:integer causes:cause[]",
      {{"cause", object_schema("kind:string axis:integer code:integer "
                               "tick:integer")}});
  if (row.call == call_faults) {
    return object_schema(members + " windows?:window[]", {{"window", window}});
  }
  if (row.call == call_fault) {
    const Json story = object_schema("title:string lines:string[] remedy:string");
    const Json write = object_schema(
        "tick:integer text:string refused:boolean "
        "by:string");
    return object_schema(
        members + " kept?:window stories?:story[] writes?:write[] samples?:samples",
        {{"window", window},
         {"story", story},
         {"write", write},
         {"samples", object_schema("tick:integer[]")}});
  }
  const Json reading = object_schema("object:string value?:integer code:integer message:string");
  return object_schema(members + " values?:reading[]", {{"reading", reading}});
}

constexpr ServiceRow of_axes(std::string_view name, std::string_view type, Right right,
                             const AxesService& service) {
  return {.name = name, .type = type, .right = right, .request = "axes:string[]", .axes = service};
}

constexpr std::array kServices{
    ServiceRow{"/take_control", "vdrive.TakeControl", Right::take_control,
               "name?:string force?:boolean silence_ms?:integer", nullptr},
    ServiceRow{"/release_control", "vdrive.ReleaseControl", Right::release_control, "", nullptr},
    of_axes("/enable", "vdrive.Enable", Right::command, {.command = EachCommand::enable}),
    of_axes("/disable", "vdrive.Disable", Right::command, {.command = EachCommand::disable}),
    of_axes("/halt", "vdrive.Halt", Right::stop,
            {.command = EachCommand::halt, .until = Until::in_force}),
    of_axes("/resume", "vdrive.Resume", Right::command,
            {.command = EachCommand::resume, .until = Until::in_force}),
    ServiceRow{"/quick_stop", "vdrive.QuickStop", Right::stop, "axes?:string[] bench?:integer",
               call_quick_stop},
    of_axes("/reset", "vdrive.Reset", Right::command, {.command = EachCommand::reset_fault}),
    ServiceRow{"/move", "vdrive.Move", Right::command,
               "axis:string position:integer relative?:boolean velocity?:integer "
               "acceleration?:integer deceleration?:integer queue?:boolean",
               call_move},
    ServiceRow{"/move_group", "vdrive.MoveGroup", Right::command,
               "moves:move[] velocity?:integer acceleration?:integer deceleration?:integer",
               call_move_group},
    ServiceRow{"/home", "vdrive.Home", Right::command, "axis:string method?:integer", call_home},
    ServiceRow{"/jog", "vdrive.Jog", Right::jog, "axis:string velocity:integer", nullptr},
    ServiceRow{"/disturb", "vdrive.Disturb", Right::command,
               "axis:string name:string value:integer", call_disturb},
    of_axes("/end_disturbances", "vdrive.EndDisturbances", Right::command,
            {.each = &Axis::end_disturbances}),
    of_axes("/store", "vdrive.Store", Right::command, {.each = &Axis::store}),
    of_axes("/restore", "vdrive.Restore", Right::command, {.each = &Axis::restore_defaults}),
    of_axes("/power_cycle", "vdrive.PowerCycle", Right::command,
            {.command = EachCommand::power_cycle}),
    ServiceRow{"/pause", "vdrive.Pause", Right::command, "bench:integer", call_pause},
    ServiceRow{"/rate", "vdrive.Rate", Right::command, "bench:integer rate:number", call_rate},
    ServiceRow{"/step", "vdrive.Step", Right::command, "bench:integer ticks:integer", call_step},
    ServiceRow{"/events", "vdrive.Events", Right::events, "bench:integer", nullptr},
    ServiceRow{"/judge", "vdrive.Judge", Right::judge, "bench:integer", nullptr},
    ServiceRow{"/freeze", "vdrive.Freeze", Right::command, "bench:integer", call_freeze},
    ServiceRow{"/faults", "vdrive.Faults", Right::none, "bench:integer", call_faults},
    ServiceRow{"/fault", "vdrive.Fault", Right::none, "window:integer axis:string", call_fault},
    ServiceRow{"/read", "vdrive.Read", Right::none, "axis:string objects:string[]", call_read},
    ServiceRow{"/write", "vdrive.Write", Right::command, "axis:string object:string value:integer",
               call_write},
};

}  // namespace

CallAnswer ServiceRow::carry_out(Session& session, const Json& asked) const {
  return axes ? call_axes(session, asked, *axes) : call(session, asked);
}

std::span<const ServiceRow> services() {
  return kServices;
}

std::vector<ServiceInfo> service_infos() {
  const Json types{{"move", object_schema("axis:string position:integer")}};
  std::vector<ServiceInfo> infos;
  infos.reserve(kServices.size());
  for (const ServiceRow& row : kServices) {
    infos.push_back({.id = static_cast<std::uint32_t>(infos.size() + 1),
                     .name = std::string(row.name),
                     .type = std::string(row.type),
                     .request_schema = object_schema(row.request, types),
                     .response_schema = response_schema(row)});
  }
  return infos;
}

std::string answer_text(const CallAnswer& answer) {
  Json json = answer.fields;
  json["ok"] = static_cast<bool>(answer.outcome);
  json["outcome"] = to_string(answer.outcome.kind());
  json["message"] = answer.outcome.message();
  json["code"] = answer.outcome.code();
  return to_line(json);
}

bool flag_of(const Json& request, const char* key) {
  if (is_absent(request, key)) return false;
  const Json& value = member(request, key);
  if (!value.is_boolean()) throw ProtocolError(in_quotes(key) + " must be true or false");
  return value.get<bool>();
}

std::optional<std::int64_t> optional_integer(const Json& request, const char* key,
                                             const NumberRange& range) {
  if (is_absent(request, key)) return std::nullopt;
  return integer_of(request, key, range);
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
