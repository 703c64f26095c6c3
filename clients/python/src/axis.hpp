// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence.hpp"
#include "python.hpp"
#include "vdrive/client/axis.hpp"

#include <utility>
#include <vector>

namespace vdrive::python {

/// An axis, and what keeps its session.
struct PyAxis {
  PyAxis(client::Axis handle, SharedPresence keeper)
      : axis(std::move(handle)), presence(std::move(keeper)) {}

  ~PyAxis() {
    if (presence && presence->is_inherited()) leave(std::move(axis));
  }

  PyAxis(const PyAxis&) = default;
  PyAxis(PyAxis&&) noexcept = default;
  PyAxis& operator=(const PyAxis&) = default;
  PyAxis& operator=(PyAxis&&) noexcept = default;

  client::Axis axis;
  SharedPresence presence;
};

/// @param axes nothing, a text or an axis, or a sequence of these
/// @return the axes; every one of the only bench where nothing was given.
/// @throws py::error_already_set where one is not found
[[nodiscard]] std::vector<client::Axis> axes_of(const SharedPresence& presence,
                                                const py::object& axes);

/// @return their addresses.
[[nodiscard]] std::vector<client::AxisId> ids_of(const std::vector<client::Axis>& axes);

/// @param name such as "enable". @throws py::value_error
[[nodiscard]] client::EachCommand each_command_of(const std::string& name);

}  // namespace vdrive::python
