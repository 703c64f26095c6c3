// SPDX-License-Identifier: Apache-2.0
#include "value_line.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive::ros2 {

double ValueLine::step(double period, double slope) noexcept {
  const double way = goal_ - now_;
  const double most = slope * period;
  if (left_ <= period && std::abs(way) <= most) {
    now_ = goal_;  // exactly, whatever the sum of the steps is
  } else {
    const double part = left_ > period ? way * period / left_ : way;
    now_ += std::clamp(part, -most, most);
  }
  left_ = std::max(0.0, left_ - period);
  return now_;
}

}  // namespace vdrive::ros2
