// SPDX-License-Identifier: Apache-2.0
#include "arguments.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/text.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

namespace vdrive::python {
namespace {

using std::chrono::nanoseconds;

// 100 years: more than any wait, less than nanoseconds hold.
constexpr double kLongest = 3.2e9;

std::int64_t in_range(std::int64_t value, std::int64_t highest, const char* what) {
  if (value >= 0 && value <= highest) return value;
  throw py::value_error(std::string(what) + " " + std::to_string(value) + " is not from 0 to " +
                        std::to_string(highest));
}

ObjectAddress address_of(std::int64_t index, std::int64_t subindex) {
  constexpr auto kLastIndex = std::numeric_limits<std::uint16_t>::max();
  constexpr auto kLastSubindex = std::numeric_limits<std::uint8_t>::max();
  return {.index = static_cast<std::uint16_t>(in_range(index, kLastIndex, "index")),
          .subindex = static_cast<std::uint8_t>(in_range(subindex, kLastSubindex, "sub-index"))};
}

/// @throws py::value_error when the member of a frame does not hold the value
template <typename Member>
Member member_of(ObjectRow row, std::int64_t value) {
  if (std::in_range<Member>(value)) return static_cast<Member>(value);
  using Limits = std::numeric_limits<Member>;
  throw py::value_error(object_text(vdrive::describe(row).address) + " = " + std::to_string(value) +
                        ": must be from " + std::to_string(Limits::min()) + " to " +
                        std::to_string(Limits::max()));
}

/// Mode, target position and controlword have members of their own in a frame.
void add_value(client::SetPoint& point, ObjectAddress object, std::int64_t value) {
  using namespace literals;
  if (object == vdrive::describe("op_mode_cmd"_object).address) {
    point.mode = static_cast<OperatingMode>(member_of<std::int8_t>("op_mode_cmd"_object, value));
  } else if (object == vdrive::describe("position_user_target_value"_object).address) {
    point.position = member_of<std::int32_t>("position_user_target_value"_object, value);
  } else if (object == vdrive::describe("ds402_controlword"_object).address) {
    point.controlword = member_of<std::uint16_t>("ds402_controlword"_object, value);
  } else {
    point.objects.push_back({.object = object, .value = value});
  }
}

}  // namespace

nanoseconds nanoseconds_of(double seconds) {
  if (!(seconds >= 0.0) || seconds > kLongest) {
    throw py::value_error("a time has 0 to 3.2e9 seconds, not " + std::to_string(seconds));
  }
  return nanoseconds(std::llround(seconds * 1e9));
}

std::chrono::milliseconds milliseconds_of(double seconds) {
  return std::chrono::ceil<std::chrono::milliseconds>(nanoseconds_of(seconds));
}

double seconds_of(nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

client::Until until_of(const std::string& until) {
  if (until == "done") return client::Until::done;
  if (until == "in_force") return client::Until::in_force;
  throw py::value_error(R"(until is "done" or "in_force", not )" + in_quotes(until));
}

client::CallOptions call_options(double timeout, const std::string& until) {
  return {.timeout = nanoseconds_of(timeout), .until = until_of(until)};
}

client::Pace pace_of(const std::string& pace) {
  if (pace == "drive") return client::Pace::drive;
  if (pace == "observe") return client::Pace::observe;
  throw py::value_error(R"(pace is "drive" or "observe", not )" + in_quotes(pace));
}

ObjectAddress object_of(const py::object& object) {
  if (py::isinstance<py::str>(object)) {
    const auto name = object.cast<std::string>();
    const auto named = parse_object(name);
    if (!named) throw py::key_error("the dictionary has no object " + in_quotes(name));
    return *named;
  }
  if (py::isinstance<py::tuple>(object)) {
    const auto [index, subindex] = object.cast<std::tuple<std::int64_t, std::int64_t>>();
    return address_of(index, subindex);
  }
  return address_of(object.cast<std::int64_t>(), 0);
}

client::SetPointFrame frame_of(const py::dict& set_points) {
  client::SetPointFrame frame;
  for (const auto& [axis, values] : set_points) {
    client::SetPoint& point = frame.axes.emplace_back();
    point.axis = axis.cast<std::uint16_t>();
    for (const auto& [object, value] : values.cast<py::dict>()) {
      add_value(point, object_of(py::reinterpret_borrow<py::object>(object)),
                value.cast<std::int64_t>());
    }
  }
  return frame;
}

}  // namespace vdrive::python
