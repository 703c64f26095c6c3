// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "py_session.hpp"
#include "python.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

/// Arguments of Python as the client library takes them.
namespace vdrive::python {

/// A number as a program gives it: an int, a float, or one of numpy. A call that takes it may be
/// given any object: the functions below say what is wrong with it, by the name of the argument.
struct Number {
  py::object value;
};

using OptionalNumber = std::optional<Number>;

/// The same where a fraction counts, such as of a time in s.
struct Real {
  py::object value;
};

using OptionalReal = std::optional<Real>;

/// What a number stands for, in the messages of errors.
struct Meaning {
  const char* name = "";  ///< of the argument
  const char* unit = "";  ///< in which it is without another one
};

/// @return the value as a program writes it, shortened, in one line.
[[nodiscard]] std::string shown(const py::handle& value);

/// A unit in which a program gives its numbers.
struct GivenUnit {
  std::string name;
  double size = 1.0;  ///< [UU] of one
};

/// @return the number. With a unit it is rounded to the nearest UU.
/// @throws py::type_error for a value that is not a number, such as True and False.
/// @throws py::value_error for a fraction without a unit, and for a number that is not from
/// `lowest`
///         to `highest`. The message has name, value and limits.
[[nodiscard]] std::int64_t whole_of(const Number& number, const Meaning& meaning,
                                    std::int64_t lowest, std::int64_t highest,
                                    const std::optional<GivenUnit>& unit = {});

/// The same, with the limits of the type.
template <typename Whole>
[[nodiscard]] Whole whole(const Number& number, const Meaning& meaning,
                          const std::optional<GivenUnit>& unit = {}) {
  using Limits = std::numeric_limits<Whole>;
  return static_cast<Whole>(whole_of(number, meaning, Limits::min(), Limits::max(), unit));
}

/// The same, or nothing where the program gave nothing.
template <typename Whole>
[[nodiscard]] std::optional<Whole> whole(const OptionalNumber& number, const Meaning& meaning,
                                         const std::optional<GivenUnit>& unit = {}) {
  if (!number) return std::nullopt;
  return whole<Whole>(*number, meaning, unit);
}

/// The most of what is counted.
inline constexpr std::int64_t kMostCounted = std::numeric_limits<std::int64_t>::max();

/// @return how many, 0 to kMostCounted. @throws as `whole_of`
[[nodiscard]] std::uint64_t count_of(const Number& number, const char* name);

/// @return the number, which may be infinite or none.
/// @throws py::type_error for a value that is not a number, such as True and False
[[nodiscard]] double real_of(const Real& number, const Meaning& meaning);

/// The same. @throws py::value_error for a number that is not from `lowest` to `highest`
[[nodiscard]] double real_within(const Real& number, const Meaning& meaning, double lowest,
                                 double highest);

/// Calls `read(object, name)` with each object of a row that an argument is, and with the name that
/// messages give it, such as "targets[1]".
template <typename Read>
void for_each_in(const py::iterable& row, const char* argument, const Read& read) {
  std::size_t place = 0;
  for (const py::handle object : row) {
    const std::string name = std::string(argument) + "[" + std::to_string(place++) + "]";
    read(py::reinterpret_borrow<py::object>(object), name.c_str());
  }
}

/// @param seconds [s] 0 to 100 years. @throws as `real_within`
[[nodiscard]] std::chrono::nanoseconds nanoseconds_of(const Real& seconds, const char* name);

/// The same, rounded up to whole milliseconds.
[[nodiscard]] std::chrono::milliseconds milliseconds_of(const Real& seconds, const char* name);

/// @return seconds [s]
[[nodiscard]] double seconds_of(std::chrono::nanoseconds duration);

/// @param until "done" or "in_force". @throws py::value_error
[[nodiscard]] client::Until until_of(const std::string& until);

/// @param timeout [s] drive time
[[nodiscard]] client::CallOptions call_options(const Real& timeout, const std::string& until);

/// @param pace "drive" or "observe". @throws py::value_error
[[nodiscard]] client::Pace pace_of(const std::string& pace);

/// @param object its index, (index, subindex), or a text: its name in the dictionary or the
/// standard, or its address such as "0x607D:1"
/// @throws py::key_error where the dictionary has no such name, py::value_error outside of the
/// range, py::type_error for anything else
[[nodiscard]] ObjectAddress object_of(const py::object& object);

/// @param set_points by the number of an axis: a dict of objects, as object_of() takes them, and
/// their values
/// @throws py::value_error for a value that the frame cannot carry
[[nodiscard]] client::SetPointFrame frame_of(const py::dict& set_points);

}  // namespace vdrive::python

namespace pybind11::detail {

template <>
struct type_caster<vdrive::python::Number> {
  PYBIND11_TYPE_CASTER(vdrive::python::Number, const_name("int"));

  bool load(handle source, bool /*convert*/) {
    value.value = reinterpret_borrow<object>(source);
    return static_cast<bool>(source);
  }
};

template <>
struct type_caster<vdrive::python::Real> {
  PYBIND11_TYPE_CASTER(vdrive::python::Real, const_name("float"));

  bool load(handle source, bool /*convert*/) {
    value.value = reinterpret_borrow<object>(source);
    return static_cast<bool>(source);
  }
};

}  // namespace pybind11::detail
