// SPDX-License-Identifier: Apache-2.0
#include "arguments.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

using std::chrono::nanoseconds;

// 100 years: more than any wait, less than nanoseconds hold.
constexpr double kLongest = 3.2e9;

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
  if (object == kObjectRows["op_mode_cmd"_object].address) {
    point.mode = static_cast<OperatingMode>(member_of<std::int8_t>("op_mode_cmd"_object, value));
  } else if (object == kObjectRows["position_user_target_value"_object].address) {
    point.position = member_of<std::int32_t>("position_user_target_value"_object, value);
  } else if (object == kObjectRows["ds402_controlword"_object].address) {
    point.controlword = member_of<std::uint16_t>("ds402_controlword"_object, value);
  } else {
    point.objects.push_back({.object = object, .value = value});
  }
}

Number number_of(const py::handle& value) {
  return {py::reinterpret_borrow<py::object>(value)};
}

/// @return such as "from 0 to 65535" and the unit.
std::string limits_text(const std::string& lowest, const std::string& highest, const char* unit) {
  const std::string text = "from " + lowest + " to " + highest;
  return *unit == '\0' ? text : text + " " + unit;
}

/// @return such as "timeout = '5'".
std::string given_text(const Meaning& meaning, const py::handle& value) {
  return std::string(meaning.name) + " = " + shown(value);
}

/// @return false for True and False, of numpy too, and for arrays: one with a single number passes
///         for a number. Bits of an enumeration have a length, too, and are numbers.
bool is_number_of_python(const py::handle& value) {
  if (PyBool_Check(value.ptr()) != 0) return false;
  if (PyLong_Check(value.ptr()) != 0) return true;
  if (py::hasattr(value, "__len__")) return false;
  const std::string_view type = Py_TYPE(value.ptr())->tp_name;
  if (type == "numpy.bool_" || type == "numpy.bool") return false;
  return PyIndex_Check(value.ptr()) != 0 || py::hasattr(value, "__float__");
}

/// @return the nearest whole number; nothing where 64 bits do not hold it.
std::optional<std::int64_t> rounded(double number) {
  // A double has no 2^63 - 1: the next one is 2^63, which is too large.
  constexpr double kTooLarge = 9223372036854775808.0;
  const double whole = std::round(number);
  const bool fits = whole >= -kTooLarge && whole < kTooLarge;  // false of what is not a number
  return fits ? std::optional(static_cast<std::int64_t>(whole)) : std::nullopt;
}

/// @param value a number without a fraction
/// @return nothing where 64 bits do not hold it.
std::optional<std::int64_t> whole_value_of(const py::object& value) {
  if (PyIndex_Check(value.ptr()) == 0) return rounded(py::float_(value));
  const auto integer = py::reinterpret_steal<py::int_>(PyNumber_Index(value.ptr()));
  if (!integer) throw py::error_already_set();
  int overflow = 0;
  const std::int64_t whole = PyLong_AsLongLongAndOverflow(integer.ptr(), &overflow);
  return overflow == 0 ? std::optional(whole) : std::nullopt;
}

/// @return infinity for an int that no float holds.
double float_of(const py::object& value) {
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() == nullptr) return number;
  if (PyErr_ExceptionMatches(PyExc_OverflowError) == 0) throw py::error_already_set();
  PyErr_Clear();
  return std::numeric_limits<double>::infinity();
}

bool has_fraction(const py::object& value) {
  if (PyIndex_Check(value.ptr()) != 0) return false;
  const double number = py::float_(value);
  return std::isfinite(number) && std::trunc(number) != number;
}

}  // namespace

std::string shown(const py::handle& value) {
  return escaped(py::repr(value).cast<std::string>());
}

std::int64_t whole_of(const Number& number, const Meaning& meaning, std::int64_t lowest,
                      std::int64_t highest, const std::optional<GivenUnit>& unit) {
  const py::object& value = number.value;
  const auto problem = [&](const std::string& expected) {
    return given_text(meaning, value) + expected;
  };
  const auto limits = [&] {
    return limits_text(std::to_string(lowest), std::to_string(highest), meaning.unit);
  };
  if (!is_number_of_python(value)) {
    throw py::type_error(
        problem(unit ? ": must be a number" : ": must be a whole number " + limits()));
  }
  if (!unit && has_fraction(value)) {
    throw py::value_error(problem(": must be a whole number " + limits()));
  }
  const auto whole = unit ? rounded(float_of(value) * unit->size) : whole_value_of(value);
  if (!whole || *whole < lowest || *whole > highest) {
    throw py::value_error(problem((unit ? " " + unit->name : "") + ": must be " + limits()));
  }
  return *whole;
}

std::uint64_t count_of(const Number& number, const char* name) {
  return static_cast<std::uint64_t>(whole_of(number, {name}, 0, kMostCounted));
}

double real_of(const Real& number, const Meaning& meaning) {
  if (is_number_of_python(number.value)) return float_of(number.value);
  const std::string unit = *meaning.unit == '\0' ? "" : std::string(" of ") + meaning.unit;
  throw py::type_error(given_text(meaning, number.value) + ": must be a number" + unit);
}

double real_within(const Real& number, const Meaning& meaning, double lowest, double highest) {
  const double value = real_of(number, meaning);
  if (value >= lowest && value <= highest) return value;
  throw py::value_error(given_text(meaning, number.value) + ": must be " +
                        limits_text(to_text(lowest), to_text(highest), meaning.unit));
}

nanoseconds nanoseconds_of(const Real& seconds, const char* name) {
  return nanoseconds(std::llround(real_within(seconds, {name, "seconds"}, 0.0, kLongest) * 1e9));
}

std::chrono::milliseconds milliseconds_of(const Real& seconds, const char* name) {
  return std::chrono::ceil<std::chrono::milliseconds>(nanoseconds_of(seconds, name));
}

double seconds_of(nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

client::Until until_of(const std::string& until) {
  if (until == "done") return client::Until::done;
  if (until == "in_force") return client::Until::in_force;
  throw py::value_error(R"(until is "done" or "in_force", not )" + in_quotes(until));
}

client::CallOptions call_options(const Real& timeout, const std::string& until) {
  return {.timeout = nanoseconds_of(timeout, "timeout"), .until = until_of(until)};
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
    if (!named) {
      const std::string meant = address_suggestion(name);
      throw py::key_error("the dictionary has no object " + in_quotes(name) +
                          (meant.empty() ? suggestion(name, names_of_objects()) : meant));
    }
    return *named;
  }
  if (py::isinstance<py::tuple>(object)) {
    const auto parts = object.cast<py::tuple>();
    if (parts.size() != 2)
      throw py::value_error("an object is (index, subindex), not " + shown(object));
    return {.index = whole<std::uint16_t>(number_of(parts[0]), {"index"}),
            .subindex = whole<std::uint8_t>(number_of(parts[1]), {"sub-index"})};
  }
  if (!is_number_of_python(object)) {
    throw py::type_error("object = " + shown(object) +
                         ": must be an index, (index, subindex), or a name");
  }
  return {.index = whole<std::uint16_t>(number_of(object), {"index"}), .subindex = 0};
}

void add_arguments(py::module_& module) {
  module.def(
      "whole_number",
      [](const std::string& name, const Number& value, std::int64_t lowest, std::int64_t highest) {
        return whole_of(value, {name.c_str()}, lowest, highest);
      },
      py::arg("name"), py::arg("value"), py::arg("lowest") = 0, py::arg("highest") = kMostCounted,
      "The value of the argument `name` as an int. Raises TypeError when the value is not a "
      "number, "
      "and ValueError when it is a fraction or outside the range. The message has name, value and "
      "range.");
  module.def(
      "real_number",
      [](const std::string& name, const Real& value) {
        return real_of(value, {name.c_str()});
      },
      py::arg("name"), py::arg("value"),
      "The value of the argument `name` as a float. Raises TypeError when it is not a number.");
  module.def(
      "nanoseconds",
      [](const std::string& name, const Real& value) {
        return nanoseconds_of(value, name.c_str()).count();
      },
      py::arg("name"), py::arg("value"),
      "The value of the argument `name`, a time in s, in ns. Raises TypeError when it is not a "
      "number, and ValueError unless it is from 0 to 100 years.");
}

client::SetPointFrame frame_of(const py::dict& set_points) {
  client::SetPointFrame frame;
  for (const auto& [axis, values] : set_points) {
    client::SetPoint& point = frame.axes.emplace_back();
    point.axis = whole<std::uint16_t>(number_of(axis), {"axis"});
    if (!py::isinstance<py::dict>(values)) {
      throw py::type_error("set_points[" + std::to_string(point.axis) + "] = " + shown(values) +
                           ": must be a dict of objects and their values");
    }
    for (const auto& [object, value] : values.cast<py::dict>()) {
      add_value(point, object_of(py::reinterpret_borrow<py::object>(object)),
                whole<std::int64_t>(number_of(value), {"value"}));
    }
  }
  return frame;
}

}  // namespace vdrive::python
