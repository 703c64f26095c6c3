// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace vdrive {

/// User units per motor revolution, fixed by the manual's defaults (607Fh, 6080h and 6081h agree on
/// 4096).
inline constexpr double kUserUnitsPerRevolution = 4096.0;

/// Speed limit of every simulated motor at the end of a tick, whatever torque drives it [UU/s]: a
/// million revolutions per minute, more than any real motor reaches. A load on an elastic shaft has
/// the limit of its motor, through the gear.
inline constexpr double kHighestMotorSpeed = 1.0e6 / 60.0 * kUserUnitsPerRevolution;

/// Values of lower_end_stop and upper_end_stop that mean no end stop, as in 607Dh [UU].
inline constexpr double kNoLowerEndStop = -2147483648.0;
inline constexpr double kNoUpperEndStop = 2147483647.0;

/// Mechanics between motor and load.
enum class Coupling : std::uint8_t {
  rigid,        ///< one inertia; the load follows the motor exactly, through the gear
  two_inertia,  ///< elastic shaft with damping and optional backlash
};

/// Which encoder the position loop and 6064h use.
enum class Feedback : std::uint8_t {
  single_encoder,  ///< encoder 1 on the motor: 6064h = 3572h and 606Ch = 3574h
  dual_encoder,    ///< encoder 2 on the load: 6064h and 606Ch are the load's, through the gear
};

/// @return the word used in a configuration: "rigid" or "two_inertia".
[[nodiscard]] constexpr std::string_view to_string(Coupling coupling) noexcept {
  return coupling == Coupling::rigid ? "rigid" : "two_inertia";
}

/// @return the word used in a configuration: "single_encoder" or "dual_encoder".
[[nodiscard]] constexpr std::string_view to_string(Feedback feedback) noexcept {
  return feedback == Feedback::single_encoder ? "single_encoder" : "dual_encoder";
}

/// @param gear_ratio 3576h over 3577h: load revolutions per motor revolution
/// @return the revolutions, per motor revolution, of the shaft whose encoder 6064h reads: 1 with
///         one encoder (motor shaft), `gear_ratio` with two (load shaft).
[[nodiscard]] constexpr double position_ratio(Feedback feedback, double gear_ratio) noexcept {
  return feedback == Feedback::single_encoder ? 1.0 : gear_ratio;
}

/// @param rpm [motor revolutions per minute]
/// @param gear_ratio 3576h over 3577h: load revolutions per motor revolution
/// @return the same velocity in the unit of 6064h [UU/s], not rounded. 4096 UU are one revolution
///         of the shaft whose encoder 6064h reads: the motor's with one encoder, the load's with
///         two (manual: load velocity = motor velocity x gear ratio).
[[nodiscard]] constexpr double velocity_of_motor(double rpm, Feedback feedback,
                                                 double gear_ratio) noexcept {
  constexpr double kSecondsAMinute = 60.0;
  return rpm * kUserUnitsPerRevolution / kSecondsAMinute * position_ratio(feedback, gear_ratio);
}

/// Physical parameters of one axis, in SI units. The member initialisers describe the default axis,
/// which reproduces the manual's examples exactly at rest. Limits:
/// vdrive/plant/model_parameters.hpp.
struct AxisModel {
  Coupling coupling = Coupling::rigid;
  Feedback feedback = Feedback::dual_encoder;

  double motor_inertia = 3.0e-4;       ///< [kg.m²]
  double load_inertia = 3.0e-4;        ///< [kg.m²] at the load shaft
  double viscous_friction = 2.0e-4;    ///< [N.m.s/rad] at the motor shaft
  double coulomb_friction = 0.05;      ///< [N.m] at the motor shaft
  double load_viscous_friction = 0.0;  ///< [N.m.s/rad] at the load shaft
  double load_coulomb_friction = 0.0;  ///< [N.m] at the load shaft
  double torque_constant = 0.6;        ///< [N.m/A]

  double coupling_stiffness = 2000.0;  ///< [N.m/rad] at the load shaft, two_inertia
  double coupling_damping = 0.05;      ///< [N.m.s/rad] at the load shaft, two_inertia
  double backlash = 0.0;               ///< [rad] at the load shaft, two_inertia

  double encoder_resolution = 8388608.0;       ///< encoder 1 [counts/revolution]
  double load_encoder_resolution = 8388608.0;  ///< encoder 2 [counts/revolution]

  double current_loop_bandwidth = 1000.0;  ///< [Hz]
  double velocity_loop_bandwidth = 100.0;  ///< [Hz]
  double position_loop_bandwidth = 16.0;   ///< [Hz]

  double gravity_torque = 0.0;  ///< [N.m] at the load shaft, constant, signed

  // Effects: an axis with all of these at their defaults has none (see has_effects).
  double brake_torque = 0.0;                 ///< [N.m] of the closed brake, at the motor shaft
  double brake_release_time = 0.0;           ///< [s] from power on until the brake is open
  double brake_engage_time = 0.0;            ///< [s] from power off until the brake is closed
  double cogging_torque = 0.0;               ///< [N.m] peak, at the motor shaft
  double cogging_periods = 24.0;             ///< [1/revolution] of the motor
  double torque_ripple = 0.0;                ///< [%] peak, of the motor torque
  double torque_ripple_periods = 24.0;       ///< [1/revolution] of the motor
  double encoder_noise = 0.0;                ///< [UU] root mean square, of encoder 1
  double load_encoder_noise = 0.0;           ///< [UU] root mean square, of encoder 2
  double encoder_noise_seed = 0.0;           ///< of both encoders; a fraction is truncated
  double lower_end_stop = kNoLowerEndStop;   ///< [UU] of the load
  double upper_end_stop = kNoUpperEndStop;   ///< [UU] of the load
  double motor_thermal_time_constant = 0.0;  ///< [s] of motor heating; 0 = no heating
};

/// @return whether `model` has a brake, cogging, torque ripple, encoder noise, an end stop or motor
///         heating.
[[nodiscard]] constexpr bool has_effects(const AxisModel& model) noexcept {
  return model.brake_torque != 0.0 || model.cogging_torque != 0.0 || model.torque_ripple != 0.0 ||
         model.encoder_noise != 0.0 || model.load_encoder_noise != 0.0 ||
         model.lower_end_stop != kNoLowerEndStop || model.upper_end_stop != kNoUpperEndStop ||
         model.motor_thermal_time_constant != 0.0;
}

}  // namespace vdrive
