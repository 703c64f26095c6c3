// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Touch probes (60B8h to 60BDh, 60D0h to 60D8h), in every mode and every power state. While one is
// enabled the bank looks at the inputs of the axis before the first and after each sub-step: an
// edge has the position and the time of the look that sees it first.

/// The encoders at a look, and when it is.
struct ProbeLook {
  double motor_reading = 0.0;     // encoder 1 [UU]
  double position_reading = 0.0;  // 6064h, not rounded [UU]
  std::uint64_t time_ns = 0;      // since the bank began [ns]
};

/// Latches the edges since the last look. Only for an axis with a bit in BlockState::probed.
void look_at_inputs(Drive& drive, const ProbeLook& look);

/// 60B8h was written; the register has the new value.
/// @param previous the value of before, under which the edges since the last look fall
void enable_touch_probes(Drive& drive, std::uint16_t previous);

/// No probe is enabled any more; for a power-up, which has reset the registers.
void forget_touch_probes(Drive& drive);

}  // namespace vdrive
