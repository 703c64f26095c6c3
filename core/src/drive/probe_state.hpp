// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive {

/// State of the touch probes between two evaluations of the inputs. The latched values are in the
/// registers.
struct TouchProbeState {
  double motor_reading = 0.0;  // encoder 1 at the last evaluation [UU]
  std::uint8_t inputs = 0;     // active inputs at the last evaluation
  std::array<std::uint8_t, 7> unused{};
};

}  // namespace vdrive
