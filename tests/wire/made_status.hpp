// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"

#include <cstdint>
#include <random>

namespace vdrive::test {

/// @return a status with a different value in every member.
inline AxisStatus make_status(unsigned seed) {
  std::minstd_rand random(seed + 1);
  AxisStatus status;
  for (const StatusMember& member : status_members()) {
    member.set(status, static_cast<std::int32_t>(random() * 3U));
  }
  return status;
}

}  // namespace vdrive::test
