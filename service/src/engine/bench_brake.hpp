// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/bench_axes.hpp"
#include "engine/bench_events.hpp"
#include "engine/frame_schedule.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// How a bench that ends brings its enabled axes to rest.
enum class Braking : std::uint8_t {
  ramp,        ///< Disable operation: the ramp of 605Ch
  quick_stop,  ///< the ramp of 605Ah
  none,        ///< Disable voltage: they coast
};

/// The end of a bench: the axes come to rest and lose their power.
class BenchBrake {
 public:
  BenchBrake(BenchAxes& axes, FrameSchedule& schedule, BenchEvents& events);

  /// Writes the controlwords that brake the axes that are still enabled; the first call also
  /// cancels the frames that wait.
  void engage(Braking braking);

  /// Once engaged: switches off what has come to rest.
  void switch_off_at_rest();

  /// @return whether the bench ends.
  [[nodiscard]] bool is_engaged() const noexcept { return braking_.has_value(); }

  /// @return whether an axis is in any other state than Not ready to switch on, Switch on disabled
  ///         and Fault.
  [[nodiscard]] bool has_power() const noexcept;

 private:
  void stop_axis(std::size_t axis, Braking braking);
  void switch_off_at_rest(std::size_t axis);
  [[nodiscard]] bool stands(std::size_t axis) const noexcept;

  BenchAxes& axes_;
  FrameSchedule& schedule_;
  BenchEvents& events_;
  std::optional<Braking> braking_;
};

}  // namespace vdrive::service
