// SPDX-License-Identifier: Apache-2.0
#include "stream_begin.hpp"

namespace vdrive::ros2 {

OperatingMode mode_of(CommandInterface interface) noexcept {
  if (interface == CommandInterface::velocity) return OperatingMode::cyclic_synchronous_velocity;
  if (interface == CommandInterface::effort) return OperatingMode::cyclic_synchronous_torque;
  return OperatingMode::cyclic_synchronous_position;
}

/// A set-point for each tick follows.
client::SetPoint begin_stream(std::uint16_t axis, OperatingMode mode) {
  return {.axis = axis, .mode = mode, .objects = client::objects_before_stream()};
}

}  // namespace vdrive::ros2
