// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/bench_axes.hpp"
#include "engine/frame_schedule.hpp"

#include <cstddef>
#include <cstdint>

namespace vdrive::service {

/// Writes objects of an axis, including the controlword. A controlword that begins a halt also
/// cancels the frames that wait for the axis. Only writes that may begin a halt need an AxisWriter.
class AxisWriter {
 public:
  AxisWriter(BenchAxes& axes, FrameSchedule& schedule);

  /// @return the abort code of the refusal, or AbortCode::none
  AbortCode write(std::size_t axis, ObjectRow row, std::int64_t value);

 private:
  [[nodiscard]] bool begins_halt(std::size_t axis, ObjectRow row,
                                 std::int64_t value) const noexcept;

  BenchAxes& axes_;
  FrameSchedule& schedule_;
};

}  // namespace vdrive::service
