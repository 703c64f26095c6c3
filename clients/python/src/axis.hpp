// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "py_session.hpp"
#include "python.hpp"
#include "vdrive/client/axis.hpp"

#include <optional>
#include <string>
#include <vector>

namespace vdrive::python {

using PyAxis = PartOfSession<client::Axis>;

/// Axes of one session; nothing: all axes of the only bench.
using GivenAxes = std::optional<std::vector<const PyAxis*>>;

/// @throws py::error_already_set if there is no single bench
[[nodiscard]] std::vector<client::Axis> axes_of(const SharedPySession& py_session,
                                                const GivenAxes& axes);

/// @return their addresses.
/// @throws as axes_of
[[nodiscard]] std::vector<client::AxisId> ids_of(const SharedPySession& py_session,
                                                 const GivenAxes& axes);

/// @param name such as "enable".
/// @throws py::value_error
[[nodiscard]] client::EachCommand each_command_of(const std::string& name);

}  // namespace vdrive::python
