// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "py_session.hpp"
#include "python.hpp"
#include "vdrive/client/axis.hpp"

#include <utility>
#include <vector>

namespace vdrive::python {

/// An axis, and what keeps its session.
struct PyAxis {
  PyAxis(client::Axis handle, SharedPySession keeper)
      : axis(std::move(handle)), py_session(std::move(keeper)) {}

  ~PyAxis() {
    if (py_session && py_session->is_inherited()) leave(std::move(axis));
  }

  PyAxis(const PyAxis&) = default;
  PyAxis(PyAxis&&) noexcept = default;
  PyAxis& operator=(const PyAxis&) = default;
  PyAxis& operator=(PyAxis&&) noexcept = default;

  client::Axis axis;
  SharedPySession py_session;
};

/// @param axes nothing, a text or an axis, or a sequence of these
/// @return the axes; every one of the only bench where nothing was given.
/// @throws py::error_already_set where one is not found
[[nodiscard]] std::vector<client::Axis> axes_of(const SharedPySession& py_session,
                                                const py::object& axes);

/// @return their addresses.
[[nodiscard]] std::vector<client::AxisId> ids_of(const std::vector<client::Axis>& axes);

/// @param name such as "enable". @throws py::value_error
[[nodiscard]] client::EachCommand each_command_of(const std::string& name);

}  // namespace vdrive::python
