// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "python.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <pybind11/numpy.h>

#include <cstddef>
#include <deque>
#include <vector>

namespace vdrive::python {

/// Samples of `axes` axes each, with a record for each axis of each sample.
class Frames {
 public:
  explicit Frames(std::size_t axes);

  [[nodiscard]] std::size_t axes() const noexcept { return axes_; }

  /// @return how many samples it has.
  [[nodiscard]] std::size_t size() const noexcept { return samples_; }

  /// Sets memory aside for so many samples, as far as that is reasonable; on huge pages where the
  /// kernel has them, as numpy does.
  void expect(std::size_t samples);

  /// Adds a sample. Needs no interpreter lock.
  /// @throws std::logic_error when it has another number of axes
  void add(const client::Observation& sample);

  /// Gives the oldest `most` samples up. With the interpreter lock.
  /// @return an array of numpy, a row per sample, a column per axis; the fields of a record are
  ///         named after the members of the status.
  [[nodiscard]] py::array take(std::size_t most);

 private:
  std::vector<std::byte> records_;
  std::size_t samples_ = 0;
  std::size_t axes_;
  std::size_t row_;  ///< bytes of one sample
};

/// The records of an array, as Frames makes it, for reading. Needs no interpreter lock but for its
/// construction; the array outlives it.
class FrameView {
 public:
  /// @param frames its rows have no gaps between them
  /// @throws py::value_error unless it has a row per sample and a column per axis of such records
  FrameView(const py::array& frames, std::size_t axes);

  /// @return how many samples it has.
  [[nodiscard]] std::size_t size() const noexcept { return samples_; }

  /// Fills a sample with the record of each axis; the addresses of the axes stay.
  /// @param row below size()
  void read(std::size_t row, client::Observation& sample) const;

 private:
  const std::byte* records_;
  std::size_t samples_;
};

/// @return the samples, of `axes` axes each, as one array.
[[nodiscard]] py::array frames_of(const std::deque<client::Observation>& samples, std::size_t axes);

/// @return the dtype of an AxisStatus as it lies in memory.
[[nodiscard]] py::dtype status_image_type();

}  // namespace vdrive::python
