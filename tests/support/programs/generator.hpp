// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/programs/command.hpp"
#include "support/programs/model.hpp"
#include "support/random_cases.hpp"
#include "vdrive/axis_configuration.hpp"
#include "vdrive/axis_status.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vdrive::test {

// What random programs tell an axis, whatever carries it: each draw suits the state and the mode
// that the axis shows, so that most commands have an effect.

inline constexpr std::int64_t kUnitsPerTurn = 4'096;

/// @return a controlword: mostly towards Operation enabled; there set-points, halts and stops, too.
[[nodiscard]] std::uint16_t draw_controlword(const AxisStatus& status, Random& random);

/// @return profile position most often, else any mode or none.
[[nodiscard]] std::int8_t draw_mode(Random& random);

/// @return what the mode in force takes: targets anywhere, streamed ones near to the demand.
[[nodiscard]] Write draw_set_point(const AxisStatus& status, Random& random);

/// @return what masters set in addition to their set-points: offsets, touch probes, 60C2h, the
/// buffer of
///         records, ways round the range of a modulo axis.
[[nodiscard]] Write draw_setting(Random& random);

/// @return any of these: mostly a controlword.
[[nodiscard]] Write draw_write(const AxisStatus& status, Random& random);

/// @return an input of the test bench 5E00h to 5E0Ah that is on, with up to 2.5 N.m of load.
[[nodiscard]] Write draw_disturbance(Random& random);

/// @return one of `kinds`; targets are up to `reach` from 0 [UU].
[[nodiscard]] Intent draw_intent(std::span<const Intent::Kind> kinds, std::int32_t reach,
                                 Random& random);

/// The same, but every other time what leads to Operation enabled, where the axis is not there.
[[nodiscard]] Intent draw_intent(const AxisStatus& status, std::span<const Intent::Kind> kinds,
                                 std::int32_t reach, Random& random);

/// An axis of a program: what its watch knows, and what its configuration has.
struct DrawnAxis {
  AxisLimits limits;
  AxisModel model;
  std::vector<InitialValue> parameters;
};

/// Draws limits for each axis. With `kinds` some kinds of axes are there, each on some of the axes:
/// limited jerk, a modulo range, switches with a place, end stops, other effects of the plant,
/// habits of other drives, a monitor of missing set-points.
[[nodiscard]] std::vector<DrawnAxis> draw_axes(std::size_t count, bool kinds, Random& random);

}  // namespace vdrive::test
