// SPDX-License-Identifier: Apache-2.0
#include "engine/changed_axes.hpp"

namespace vdrive::service {

ChangedAxes::ChangedAxes(std::size_t axes) : queue_(axes), is_marked_(axes) {}

void ChangedAxes::mark(std::size_t axis) noexcept {
  if (is_marked_[axis]) return;
  is_marked_[axis] = true;
  queue_[(first_ + count_) % queue_.size()] = static_cast<std::uint16_t>(axis);
  ++count_;
}

std::size_t ChangedAxes::take() noexcept {
  const std::size_t axis = queue_[first_];
  first_ = (first_ + 1) % queue_.size();
  --count_;
  is_marked_[axis] = false;
  return axis;
}

}  // namespace vdrive::service
