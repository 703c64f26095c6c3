// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "py_session.hpp"
#include "python.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <string>
#include <vector>

/// Arguments of Python as the client library takes them.
namespace vdrive::python {

/// @param seconds [s] finite, 0 or more. @throws py::value_error
[[nodiscard]] std::chrono::nanoseconds nanoseconds_of(double seconds);

/// The same, rounded up to whole milliseconds.
[[nodiscard]] std::chrono::milliseconds milliseconds_of(double seconds);

/// @return seconds [s]
[[nodiscard]] double seconds_of(std::chrono::nanoseconds duration);

/// @param until "done" or "in_force". @throws py::value_error
[[nodiscard]] client::Until until_of(const std::string& until);

/// @param timeout [s] drive time
[[nodiscard]] client::CallOptions call_options(double timeout, const std::string& until);

/// @param pace "drive" or "observe". @throws py::value_error
[[nodiscard]] client::Pace pace_of(const std::string& pace);

/// @param object its index, (index, subindex), or a text: its name in the dictionary or the
/// standard, or its address such as "0x607D:1"
/// @throws py::key_error where the dictionary has no such name, py::value_error outside of the
/// range
[[nodiscard]] ObjectAddress object_of(const py::object& object);

/// @param set_points by the number of an axis: a dict of objects, as object_of() takes them, and
/// their values
/// @throws py::value_error for a value that the frame cannot carry
[[nodiscard]] client::SetPointFrame frame_of(const py::dict& set_points);

}  // namespace vdrive::python
