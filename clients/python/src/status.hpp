// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <pybind11/numpy.h>

#include <deque>

namespace vdrive::python {

/// @return an array of numpy with a record for each axis of each sample, its fields named after the
///         members of the status.
/// @param samples of the same axes, whose number is `axes`
[[nodiscard]] py::object frames_of(const std::deque<client::Observation>& samples,
                                   std::size_t axes);

/// @return the dtype of an AxisStatus as it lies in memory.
[[nodiscard]] py::dtype status_image_type();

}  // namespace vdrive::python
