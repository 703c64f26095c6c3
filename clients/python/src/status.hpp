// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <pybind11/numpy.h>

#include <cstddef>
#include <deque>

namespace vdrive::python {

/// An array of numpy with a record for each axis of each sample, its fields named after the members
/// of the status. Made and destroyed with the interpreter lock.
class Frames {
 public:
  /// @param samples how many come, of `axes` axes each
  Frames(std::size_t samples, std::size_t axes);

  /// Writes the next sample. Needs no interpreter lock.
  /// @throws std::logic_error when it has another number of axes, or is one too many
  void add(const client::Observation& sample);

  /// @return the array, whole once every sample was added.
  [[nodiscard]] const py::array& array() const noexcept { return array_; }

 private:
  py::array array_;
  std::byte* place_;  ///< of the next record
  std::size_t samples_;
  std::size_t axes_;
};

/// @return the samples, of `axes` axes each, as one array.
[[nodiscard]] py::array frames_of(const std::deque<client::Observation>& samples, std::size_t axes);

/// @return the dtype of an AxisStatus as it lies in memory.
[[nodiscard]] py::dtype status_image_type();

}  // namespace vdrive::python
