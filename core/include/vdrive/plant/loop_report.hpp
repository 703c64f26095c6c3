// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_configuration.hpp"

#include <chrono>

namespace vdrive {

/// The performance of an axis's servo loops with its motor, gear and load, computed from the design
/// without moving anything. It is valid for small deviations from a motion in progress, and leaves
/// out Coulomb friction, backlash and encoder quantisation.
struct LoopReport {
  double gear_ratio = 1.0;          ///< 3576h over 3577h: load revolutions per motor revolution
  double inertia_ratio = 1.0;       ///< inertia seen at the motor over that of the motor
  double load_resonance = 0.0;      ///< of the load on its shaft with the motor at rest [Hz]; 0 =
                                    ///< rigid shaft
  double velocity_bandwidth = 0.0;  ///< reached by the velocity loop [Hz]
  double position_bandwidth = 0.0;  ///< reached by the position loop [Hz]
  double ringing = 0.0;             ///< the slowest-decaying oscillation up to twice the configured
                                    ///< velocity bandwidth [Hz]; 0 = none
  double ringing_time = 0.0;        ///< until it has decayed to 2 % [s]; infinity = it grows
  double torque_needed = 0.0;       ///< at the motor, for 6083h and 6084h [N.m]
  double torque_limit = 0.0;        ///< the lowest of 6072h, 60E0h and 60E1h [N.m]
};

/// @throws std::invalid_argument as AxisBank does.
[[nodiscard]] LoopReport examine_loops(const AxisConfiguration& axis,
                                       std::chrono::microseconds period);

}  // namespace vdrive
