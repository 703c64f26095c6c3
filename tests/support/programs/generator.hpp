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

// The commands that random programs give to an axis, over any transport. Each draw suits the state
// and the mode that the axis shows, so most commands have an effect.

inline constexpr std::int64_t kUnitsPerTurn = 4'096;

/// @return a controlword that mostly leads towards Operation enabled; in that state also new
///         set-points, halts and stops.
[[nodiscard]] std::uint16_t draw_controlword(const AxisStatus& status, Random& random);

/// @return profile position mode most often, else any mode or none.
[[nodiscard]] std::int8_t draw_mode(Random& random);

/// @return a set-point for the mode in force: targets anywhere, streamed ones close to the demand.
[[nodiscard]] Write draw_set_point(const AxisStatus& status, Random& random);

/// @return a setting that masters use in addition to set-points: offsets, touch probes, 60C2h, the
///         buffer of records, directions around the range of a modulo axis.
[[nodiscard]] Write draw_setting(Random& random);

/// @return any of the above, mostly a controlword.
[[nodiscard]] Write draw_write(const AxisStatus& status, Random& random);

/// @return an active test-bench input, 5E00h to 5E0Ah, with up to 2.5 N.m of load.
[[nodiscard]] Write draw_disturbance(Random& random);

/// @return one of `kinds`; its target is within `reach` of 0 [UU].
[[nodiscard]] Intent draw_intent(std::span<const Intent::Kind> kinds, std::int32_t reach,
                                 Random& random);

/// The same, but if the axis is not in Operation enabled, every second draw leads there.
[[nodiscard]] Intent draw_intent(const AxisStatus& status, std::span<const Intent::Kind> kinds,
                                 std::int32_t reach, Random& random);

/// An axis of a program: the limits that its watch knows, and its configuration.
struct DrawnAxis {
  AxisLimits limits;
  AxisModel model;
  std::vector<InitialValue> parameters;
};

/// Draws limits for each axis. With `kinds`, some axes also get some of: limited jerk, a modulo
/// range, switches with a position, end stops, other effects of the plant, habits of other drives,
/// a monitor of missing set-points.
[[nodiscard]] std::vector<DrawnAxis> draw_axes(std::size_t count, bool kinds, Random& random);

}  // namespace vdrive::test
