// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simulation/axis_watch.hpp"
#include "support/random_cases.hpp"
#include "vdrive/axis_configuration.hpp"

#include <cstddef>
#include <vector>

namespace vdrive::simulation {

using test::Random;

/// An axis of a seed: what its watch knows, and what its configuration has.
struct DrawnAxis {
  AxisLimits limits;
  AxisModel model;
  std::vector<InitialValue> parameters;
};

/// Draws limits for each axis. In a seed with `kinds` some kinds of axes are there, each on some of
/// the axes: limited jerk, a modulo range, switches with a place, end stops, other effects of the
/// plant, habits of other drives, a monitor of missing set-points.
[[nodiscard]] std::vector<DrawnAxis> draw_axes(std::size_t count, bool kinds, Random& random);

}  // namespace vdrive::simulation
