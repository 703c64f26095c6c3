// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace vdrive {

/// @return the torque limit: the lower of 6072h (`highest`) and 60E0h or 60E1h (`relative`) times
///         `unit`; `relative` = 0 disables the latter. 60E0h and 60E1h limit both torque and
///         current, so `unit` is the smaller of the rated torque and the torque at rated current.
///         `highest`, `unit` and the result have the same unit.
[[nodiscard]] inline double torque_limit(double highest, double relative, double unit) noexcept {
  return relative == 0.0 ? highest : std::min(highest, relative * unit);
}

}  // namespace vdrive
