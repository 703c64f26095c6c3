// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/plant/axis_model.hpp"

#include <array>
#include <string_view>

namespace vdrive::service {

/// A physical parameter as a configuration names it.
struct ModelParameter {
  std::string_view name;
  double AxisModel::*member;
  std::string_view unit;
  double lowest;
  bool above_lowest;  ///< the lowest value itself is not allowed
};

/// Every number in AxisModel, with the limits that hold whatever the coupling.
inline constexpr std::array<ModelParameter, 15> kModelParameters{{
    {"motor_inertia", &AxisModel::motor_inertia, "kg.m2", 0.0, true},
    {"load_inertia", &AxisModel::load_inertia, "kg.m2", 0.0, false},
    {"viscous_friction", &AxisModel::viscous_friction, "N.m.s/rad", 0.0, false},
    {"coulomb_friction", &AxisModel::coulomb_friction, "N.m", 0.0, false},
    {"load_viscous_friction", &AxisModel::load_viscous_friction, "N.m.s/rad", 0.0, false},
    {"load_coulomb_friction", &AxisModel::load_coulomb_friction, "N.m", 0.0, false},
    {"torque_constant", &AxisModel::torque_constant, "N.m/A", 0.0, true},
    {"coupling_stiffness", &AxisModel::coupling_stiffness, "N.m/rad", 0.0, true},
    {"coupling_damping", &AxisModel::coupling_damping, "N.m.s/rad", 0.0, false},
    {"backlash", &AxisModel::backlash, "rad", 0.0, false},
    {"encoder_resolution", &AxisModel::encoder_resolution, "counts/revolution",
     kUserUnitsPerRevolution, false},
    {"load_encoder_resolution", &AxisModel::load_encoder_resolution, "counts/revolution",
     kUserUnitsPerRevolution, false},
    {"current_loop_bandwidth", &AxisModel::current_loop_bandwidth, "Hz", 0.0, true},
    {"velocity_loop_bandwidth", &AxisModel::velocity_loop_bandwidth, "Hz", 0.0, true},
    {"position_loop_bandwidth", &AxisModel::position_loop_bandwidth, "Hz", 0.0, true},
}};

}  // namespace vdrive::service
