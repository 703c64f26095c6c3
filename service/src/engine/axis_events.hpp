// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_events.hpp"
#include "engine/frame_schedule.hpp"
#include "engine/masters.hpp"
#include "vdrive/axis_status.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// Reports after each tick how the axes changed: their states, new faults, ignored set-points.
class AxisEvents {
 public:
  AxisEvents(BenchAxes& axes, const Masters& masters, FrameSchedule& schedule, BenchEvents& events,
             Counters& counters);

  /// Reports the changes since the last call. Cancels the frames that wait for an axis that has
  /// left Operation enabled.
  void report_changes();

 private:
  static constexpr std::size_t kWordSize = 64;

  /// The last reported values of an axis.
  struct Seen {
    std::uint16_t statusword = 0;
    std::uint16_t error_code = 0;
    std::uint32_t ignored_set_points = 0;
    std::uint32_t fault_count = 0;

    static Seen of(const AxisStatus& status) noexcept;
  };

  /// @return the axes of a word that have changed: bit n stands for axis kWordSize * word + n.
  [[nodiscard]] std::uint64_t changes_of(std::size_t word) const noexcept;
  void report(std::size_t axis);
  void report_state(std::size_t axis, const AxisStatus& status, const Seen& seen);
  void report_faults(std::size_t axis, const AxisStatus& status, const Seen& seen);
  void report_set_points(std::size_t axis, const AxisStatus& status, const Seen& seen);

  BenchAxes& axes_;
  const Masters& masters_;
  FrameSchedule& schedule_;
  BenchEvents& events_;
  Counters& counters_;
  std::vector<Seen> seen_;
  std::vector<std::uint64_t> changed_;  ///< one bit per axis
};

}  // namespace vdrive::service
