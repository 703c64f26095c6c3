// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <pybind11/numpy.h>

#include <cstddef>
#include <deque>
#include <vector>

namespace vdrive::python {

/// Samples of `axes` axes each, with one record per axis and sample.
class Frames {
 public:
  explicit Frames(std::size_t axes);

  [[nodiscard]] std::size_t axes() const noexcept { return axes_; }

  /// @return the number of samples.
  [[nodiscard]] std::size_t size() const noexcept { return samples_; }

  /// Reserves memory for that many samples, within reason; on huge pages if the kernel has them, as
  /// numpy does.
  void expect(std::size_t samples);

  /// Adds a sample. Needs no interpreter lock.
  /// @throws std::logic_error if it has another number of axes
  void add(const client::Observation& sample);

  /// Removes the oldest `most` samples. Call with the interpreter lock.
  /// @return a numpy array with a row per sample and a column per axis; the fields of a record are
  ///         named after the members of the status.
  [[nodiscard]] py::array take(std::size_t most);

 private:
  std::vector<std::byte> records_;
  std::size_t samples_ = 0;
  std::size_t axes_;
  std::size_t row_;  ///< bytes per sample
};

/// Read access to the records of an array made by Frames. Needs the interpreter lock only for its
/// construction; the array must outlive it.
class FrameView {
 public:
  /// @param frames must have no gaps between its rows
  /// @throws py::value_error unless it has a row per sample and a column per axis of such records
  FrameView(const py::array& frames, std::size_t axes);

  /// @return the number of samples.
  [[nodiscard]] std::size_t size() const noexcept { return samples_; }

  /// Fills a sample with the record of each axis; the addresses of the axes are kept.
  /// @param row below size()
  void read(std::size_t row, client::Observation& sample) const;

 private:
  const std::byte* records_;
  std::size_t samples_;
};

/// @return the samples, of `axes` axes each, as one array.
[[nodiscard]] py::array frames_of(const std::deque<client::Observation>& samples, std::size_t axes);

/// @return the dtype for the memory layout of an AxisStatus.
[[nodiscard]] py::dtype status_image_type();

}  // namespace vdrive::python
