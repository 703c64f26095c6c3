// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/bench_axes.hpp"
#include "engine/bench_events.hpp"
#include "engine/frame_schedule.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// How a bench brings its enabled axes to rest when it ends.
enum class Braking : std::uint8_t {
  ramp,        ///< Disable operation: the ramp of 605Ch
  quick_stop,  ///< the ramp of 605Ah
  none,        ///< Disable voltage: they coast
};

/// Ends a bench: brings the axes to rest and removes their power.
class BenchBrake {
 public:
  BenchBrake(BenchAxes& axes, FrameSchedule& schedule, BenchEvents& events);

  /// Writes the controlwords that brake the axes that are still enabled. The first call also
  /// cancels all waiting frames.
  void engage(Braking braking);

  /// Once engaged, switches off the axes that have come to rest.
  void switch_off_at_rest();

  /// @return whether the bench is ending.
  [[nodiscard]] bool is_engaged() const noexcept { return braking_.has_value(); }

  /// @return whether any axis is in a state other than Not ready to switch on, Switch on disabled
  ///         and Fault.
  [[nodiscard]] bool has_power() const noexcept;

 private:
  void stop_axis(std::size_t axis, Braking braking);
  void switch_off_at_rest(std::size_t axis);
  [[nodiscard]] bool is_at_standstill(std::size_t axis) const noexcept;

  BenchAxes& axes_;
  FrameSchedule& schedule_;
  BenchEvents& events_;
  std::optional<Braking> braking_;
};

}  // namespace vdrive::service
