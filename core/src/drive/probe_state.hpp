// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive {

/// What the touch probes keep between two looks at the inputs. What they have latched stands in the
/// registers.
struct TouchProbeState {
  double motor_reading = 0.0;  // encoder 1 at the last look [UU]
  std::uint8_t inputs = 0;     // that were active at the last look
  std::array<std::uint8_t, 7> unused{};
};

}  // namespace vdrive
