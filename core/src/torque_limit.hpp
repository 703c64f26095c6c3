// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace vdrive {

/// @return the torque limit: 6072h (`highest`) or 60E0h or 60E1h (`relative`) times `unit`, the
///         lower one; `relative` = 0 switches the latter off. 60E0h and 60E1h bound torque and
///         current, so `unit` is the lesser of the rated torque and the torque of the rated
///         current. `highest`, `unit` and the result have one unit.
[[nodiscard]] inline double torque_limit(double highest, double relative, double unit) noexcept {
  return relative == 0.0 ? highest : std::min(highest, relative * unit);
}

}  // namespace vdrive
