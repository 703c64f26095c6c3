// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Touch probes (60B8h to 60BDh, 60D0h to 60D8h), in every mode and power state. While one is
// enabled, the bank evaluates the inputs of the axis before the first and after each sub-step. An
// edge gets the position and time of the evaluation that first sees it.

/// Encoder readings and time of an evaluation of the inputs.
struct ProbeEvaluation {
  double motor_reading = 0.0;     // encoder 1 [UU]
  double position_reading = 0.0;  // 6064h, not rounded [UU]
  std::uint64_t time_ns = 0;      // since the bank started [ns]
};

/// Latches the edges since the last evaluation. Only for an axis with its bit in
/// BlockState::probed.
void evaluate_inputs(Drive& drive, const ProbeEvaluation& look);

/// 60B8h was written; the register has the new value.
/// @param previous the previous value, which applies to the edges since the last evaluation
void enable_touch_probes(Drive& drive, std::uint16_t previous);

/// Disables all probes, for a power-up that has reset the registers.
void forget_touch_probes(Drive& drive);

}  // namespace vdrive
