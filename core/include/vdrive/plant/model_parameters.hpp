// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/plant/axis_model.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive {

/// A numeric parameter of AxisModel. Its default is the initialiser of the member.
struct ModelParameter {
  std::string_view name;  ///< of the member and of the key in a configuration
  double AxisModel::*member;
  std::string_view unit;  ///< empty = no unit
  std::string_view what;  ///< what it belongs to or where it acts
  double lowest;
  double highest;
  bool from_zero_if_rigid = false;  ///< for a rigid axis the lowest value is 0
};

/// Every numeric parameter of AxisModel with its limits: the configuration reads, checks and prints
/// these, and the bank checks them.
inline constexpr std::array<ModelParameter, 29> kModelParameters{{
    {"motor_inertia", &AxisModel::motor_inertia, "kg.m2", "of the rotor", 1.0e-8, 1.0e4},
    {"load_inertia", &AxisModel::load_inertia, "kg.m2", "at the load shaft", 1.0e-8, 1.0e4, true},
    {"viscous_friction", &AxisModel::viscous_friction, "N.m.s/rad", "at the motor shaft", 0.0,
     1.0e4},
    {"coulomb_friction", &AxisModel::coulomb_friction, "N.m", "at the motor shaft", 0.0, 1.0e4},
    {"load_viscous_friction", &AxisModel::load_viscous_friction, "N.m.s/rad", "at the load shaft",
     0.0, 1.0e4},
    {"load_coulomb_friction", &AxisModel::load_coulomb_friction, "N.m", "at the load shaft", 0.0,
     1.0e4},
    {"torque_constant", &AxisModel::torque_constant, "N.m/A", "of the motor", 1.0e-6, 1.0e4},
    {"coupling_stiffness", &AxisModel::coupling_stiffness, "N.m/rad", "of the shaft, at the load",
     1.0e-3, 1.0e7},
    {"coupling_damping", &AxisModel::coupling_damping, "N.m.s/rad", "of the shaft, at the load",
     0.0, 1.0e4},
    {"backlash", &AxisModel::backlash, "rad", "of the shaft, at the load, both directions together",
     0.0, 6.3},
    {"encoder_resolution", &AxisModel::encoder_resolution, "counts/revolution",
     "of encoder 1, on the motor", kUserUnitsPerRevolution, 4294967296.0},
    {"load_encoder_resolution", &AxisModel::load_encoder_resolution, "counts/revolution",
     "of encoder 2, on the load", kUserUnitsPerRevolution, 4294967296.0},
    {"current_loop_bandwidth", &AxisModel::current_loop_bandwidth, "Hz", "of the current loop", 1.0,
     4000.0},
    {"velocity_loop_bandwidth", &AxisModel::velocity_loop_bandwidth, "Hz", "of the velocity loop",
     0.1, 1000.0},
    {"position_loop_bandwidth", &AxisModel::position_loop_bandwidth, "Hz", "of the position loop",
     0.01, 500.0},
    {"gravity_torque", &AxisModel::gravity_torque, "N.m",
     "of the weight of a vertical axis, at the load shaft", -1.0e4, 1.0e4},
    {"brake_torque", &AxisModel::brake_torque, "N.m",
     "that the holding brake holds, at the motor shaft; 0 = no brake", 0.0, 1.0e4},
    {"brake_release_time", &AxisModel::brake_release_time, "s",
     "from the power stage on to the open brake", 0.0, 10.0},
    {"brake_engage_time", &AxisModel::brake_engage_time, "s",
     "from the power stage off to the closed brake", 0.0, 10.0},
    {"cogging_torque", &AxisModel::cogging_torque, "N.m", "largest, at the motor shaft", 0.0,
     1.0e4},
    {"cogging_periods", &AxisModel::cogging_periods, "1/revolution", "of the cogging torque", 1.0,
     1.0e4},
    {"torque_ripple", &AxisModel::torque_ripple, "%", "largest, of the torque of the motor", 0.0,
     100.0},
    {"torque_ripple_periods", &AxisModel::torque_ripple_periods, "1/revolution",
     "of the torque ripple", 1.0, 1.0e4},
    {"encoder_noise", &AxisModel::encoder_noise, "UU", "of encoder 1, root mean square", 0.0,
     1.0e4},
    {"load_encoder_noise", &AxisModel::load_encoder_noise, "UU", "of encoder 2, root mean square",
     0.0, 1.0e4},
    {"encoder_noise_seed", &AxisModel::encoder_noise_seed, "",
     "of the noise of both encoders, a whole number", 0.0, 4294967295.0},
    {"lower_end_stop", &AxisModel::lower_end_stop, "UU",
     "of the load, as counted at first power-up; -2147483648 = none", kNoLowerEndStop,
     kNoUpperEndStop},
    {"upper_end_stop", &AxisModel::upper_end_stop, "UU",
     "of the load, as counted at first power-up; 2147483647 = none", kNoLowerEndStop,
     kNoUpperEndStop},
    {"motor_thermal_time_constant", &AxisModel::motor_thermal_time_constant, "s",
     "of the heat of the motor (I2t); 0 = it stays cold", 0.0, 1.0e6},
}};

/// @return `number` with the unit of `parameter`, such as "6.3 rad", or just the number if it has
///         none.
[[nodiscard]] std::string with_unit(double number, const ModelParameter& parameter);

/// @return nothing when the model's value of `parameter` is within its limits, otherwise the
///         limits, such as "must be from 0 to 6.3 rad". The lower end stop must also be below the
///         upper one; only the check of the lower one reports this.
[[nodiscard]] std::optional<std::string> limits_broken(const AxisModel& model,
                                                       const ModelParameter& parameter);

/// @throws std::invalid_argument when a parameter is out of its limits; the message gives
///         parameter, value, unit and limits.
void validate(const AxisModel& model);

}  // namespace vdrive
