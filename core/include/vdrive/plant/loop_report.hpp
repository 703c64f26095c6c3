// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_configuration.hpp"

#include <chrono>

namespace vdrive {

/// What the servo loops of an axis can make of its motor, gear and load: computed from the design,
/// nothing moves. Small movements at speed are described, without friction between bodies, backlash
/// and encoder counts.
struct LoopReport {
  double gear_ratio = 1.0;      ///< 3576h over 3577h: turns of the load for one of the motor
  double inertia_ratio = 1.0;   ///< motor and load as the motor feels them, over the motor alone
  double load_resonance = 0.0;  ///< of the load on its shaft behind a motor that stands [Hz]; 0 =
                                ///< rigid shaft
  double velocity_bandwidth = 0.0;  ///< that the velocity loop reaches [Hz]
  double position_bandwidth = 0.0;  ///< that the position loop reaches [Hz]
  double ringing = 0.0;        ///< oscillation up to twice the configured velocity bandwidth that
                               ///< decays most slowly [Hz]; 0 = none
  double ringing_time = 0.0;   ///< until 2 % of it are left [s]; infinity = it grows
  double torque_needed = 0.0;  ///< at the motor, for 6083h and 6084h [N.m]
  double torque_limit = 0.0;   ///< 6072h, 60E0h and 60E1h [N.m]
};

/// @throws std::invalid_argument what AxisBank throws
[[nodiscard]] LoopReport examine_loops(const AxisConfiguration& axis,
                                       std::chrono::microseconds period);

}  // namespace vdrive
