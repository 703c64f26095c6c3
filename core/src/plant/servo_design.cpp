// SPDX-License-Identifier: Apache-2.0
//
// The only place with a matrix exponential. Eigen's own vectorisation is off here, so that the
// coefficients are bit-identical on every machine and in every build.
#define EIGEN_DONT_VECTORIZE
#include "plant/servo_design.hpp"

#include <Eigen/Core>
#include <unsupported/Eigen/MatrixFunctions>

#include <algorithm>
#include <cmath>

namespace vdrive {
namespace {

/// exp([A B; 0 0] h) gives the exact step of x' = A x + B u with u held.
template <int States, int Inputs>
Eigen::Matrix<double, States, States + Inputs> discretise(
    const Eigen::Matrix<double, States, States + Inputs>& system, double step) {
  constexpr int kSize = States + Inputs;
  Eigen::Matrix<double, kSize, kSize> whole = Eigen::Matrix<double, kSize, kSize>::Zero();
  whole.template topRows<States>() = system * step;
  const Eigen::Matrix<double, kSize, kSize> exponential = whole.exp();
  return exponential.template topRows<States>();
}

/// Gains of position and velocity loop [1/s]. The gain of the velocity loop is its torque per
/// velocity over the inertia on which torque_unit() is based.
struct Gains {
  double position;
  double velocity;
};

/// Slows down loops that would ring on a soft shaft. To the load (inertia J), the velocity loop is
/// a damper (coefficient d) that acts through the spring of the shaft (stiffness k). A stiff loop
/// gives the resonance of the load the damping ratio sqrt(k J) / (2 d), to which the coupling adds
/// its own. The position loop reduces it by position gain / (2 resonance). If nothing would be
/// left, d is matched to the spring, d = sqrt(k J), which damps best, and the position loop keeps
/// its ratio to the velocity loop.
Gains on_shaft(const AxisModel& model, double ratio, const Gains& wanted) {
  const double impedance = std::sqrt(model.coupling_stiffness * model.load_inertia);
  const double resonance = std::sqrt(model.coupling_stiffness / model.load_inertia);
  const double matched = ratio * ratio * impedance / model.motor_inertia;
  const double damped = matched / wanted.velocity + model.coupling_damping / impedance;
  if (damped >= wanted.position / resonance || matched >= wanted.velocity) return wanted;
  return {.position = wanted.position * (matched / wanted.velocity), .velocity = matched};
}

/// The gains for the configured bandwidths, as far as motor and load allow.
Gains gains_of(const AxisModel& model, const Gear& gear, double inertia_ratio) {
  const double bandwidth = kTwoPi * model.velocity_loop_bandwidth;
  Gains gains{.position = kTwoPi * model.position_loop_bandwidth,
              .velocity = bandwidth * inertia_ratio};
  // Above the resonance the loop acts on the motor alone. With the inertia of the motor alone it
  // must not be faster than the current loop, otherwise it rings at full torque under a heavy
  // elastic load.
  const double highest = kTwoPi * model.current_loop_bandwidth;
  if (gains.velocity > highest) {
    gains.velocity = highest;
    // Half as fast as the inner velocity loop: a step then overshoots by less than 10 %.
    gains.position = std::min(gains.position, 0.5 * highest / inertia_ratio);
  }
  return model.coupling == Coupling::rigid ? gains : on_shaft(model, ratio_of(gear), gains);
}

/// Loop settings common to both kinds of axis. `unit_inertia` is the inertia of the torque unit,
/// `whole_inertia` the one that the loop accelerates, both at the motor.
void design_loop(const AxisModel& model, const Gear& gear, double substep, double unit_inertia,
                 double whole_inertia, std::size_t lane, LoopParameters& loop) {
  // The PI zero is a decade below the velocity bandwidth: enough phase margin and quick settling.
  constexpr double kIntegralRatio = 0.1;
  const bool dual = model.feedback == Feedback::dual_encoder;
  const double inertia_ratio = whole_inertia / unit_inertia;
  const Gains gains = gains_of(model, gear, inertia_ratio);
  loop.position_gain[lane] = gains.position;
  loop.velocity_gain[lane] = gains.velocity;
  loop.integral_step[lane] =
      gains.velocity * (gains.velocity / inertia_ratio) * kIntegralRatio * substep;
  loop.ratio[lane] = ratio_of(gear);
  loop.inverse_ratio[lane] = dual ? 1.0 / ratio_of(gear) : 1.0;
  loop.feed_forward[lane] = inertia_ratio * loop.inverse_ratio[lane];
  loop.closes_on_load[lane] = dual ? 1.0 : 0.0;
  const double load_resolution = dual ? model.load_encoder_resolution : model.encoder_resolution;
  loop.counts_per_unit[lane] = model.encoder_resolution / kUserUnitsPerRevolution;
  loop.units_per_count[lane] = kUserUnitsPerRevolution / model.encoder_resolution;
  loop.load_counts_per_unit[lane] = load_resolution / kUserUnitsPerRevolution;
  loop.load_units_per_count[lane] = kUserUnitsPerRevolution / load_resolution;
}

double whole_inertia(const AxisModel& model, const Gear& gear) noexcept {
  const double ratio = ratio_of(gear);
  return model.motor_inertia + model.load_inertia * ratio * ratio;
}

using Rigid = Eigen::Matrix<double, 3, 5>;    // [x v T | u d]
using Elastic = Eigen::Matrix<double, 5, 8>;  // [twist vm vl T xm | u dm dl]

/// Columns of the elastic model: states, then inputs.
namespace column {
enum : int {
  twist,
  motor_velocity,
  load_velocity,
  torque,
  motor_position,
  command,
  motor_load,
  load_load,
};
}  // namespace column

/// Continuous model of the two inertias. Torques are divided by the inertia of the motor (u, T, dm)
/// or of the load (dl), all in UU/s².
Elastic elastic_system(const AxisModel& model, double ratio, double stiffness, double damping) {
  const double current_loop = kTwoPi * model.current_loop_bandwidth;
  const double jm = model.motor_inertia;
  const double jl = model.load_inertia;
  Elastic system = Elastic::Zero();
  system(column::twist, column::motor_velocity) = ratio;
  system(column::twist, column::load_velocity) = -1.0;
  system(column::motor_velocity, column::twist) = -ratio * stiffness / jm;
  system(column::motor_velocity, column::motor_velocity) =
      -(model.viscous_friction + ratio * ratio * damping) / jm;
  system(column::motor_velocity, column::load_velocity) = ratio * damping / jm;
  system(column::motor_velocity, column::torque) = 1.0;
  system(column::motor_velocity, column::motor_load) = 1.0;
  system(column::load_velocity, column::twist) = stiffness / jl;
  system(column::load_velocity, column::motor_velocity) = ratio * damping / jl;
  system(column::load_velocity, column::load_velocity) =
      -(model.load_viscous_friction + damping) / jl;
  system(column::load_velocity, column::load_load) = 1.0;
  system(column::torque, column::torque) = -current_loop;
  system(column::torque, column::command) = current_loop;
  system(column::motor_position, column::motor_velocity) = 1.0;
  return system;
}

template <typename Row>
void set_row(const Row& values, std::size_t lane, ElasticRow& row) {
  row.twist[lane] = values(column::twist);
  row.motor_velocity[lane] = values(column::motor_velocity);
  row.load_velocity[lane] = values(column::load_velocity);
  row.torque[lane] = values(column::torque);
  row.command[lane] = values(column::command);
  row.motor_load[lane] = values(column::motor_load);
  row.load_load[lane] = values(column::load_load);
}

}  // namespace

double torque_unit(const AxisModel& model, const Gear& gear) noexcept {
  const double inertia =
      model.coupling == Coupling::rigid ? whole_inertia(model, gear) : model.motor_inertia;
  return inertia / kUserUnitsPerRadian;
}

double load_torque_factor(const AxisModel& model, const Gear& gear) noexcept {
  return model.coupling == Coupling::rigid
             ? ratio_of(gear) * kUserUnitsPerRadian / whole_inertia(model, gear)
             : kUserUnitsPerRadian / model.load_inertia;
}

void design_lane(const AxisModel& model, const Gear& gear, double substep, std::size_t lane,
                 RigidParameters& parameters) {
  const double ratio = ratio_of(gear);
  const double inertia = whole_inertia(model, gear);
  const double current_loop = kTwoPi * model.current_loop_bandwidth;
  design_loop(model, gear, substep, inertia, inertia, lane, parameters.loop);
  Rigid system = Rigid::Zero();
  system(0, 1) = 1.0;
  system(1, 1) = -(model.viscous_friction + model.load_viscous_friction * ratio * ratio) / inertia;
  system(1, 2) = 1.0;
  system(1, 4) = 1.0;
  system(2, 2) = -current_loop;
  system(2, 3) = current_loop;
  const Rigid step = discretise<3, 2>(system, substep);
  parameters.position_from_velocity[lane] = step(0, 1);
  parameters.position_from_torque[lane] = step(0, 2);
  parameters.position_from_command[lane] = step(0, 3);
  parameters.position_from_load[lane] = step(0, 4);
  parameters.velocity_from_velocity[lane] = step(1, 1);
  parameters.velocity_from_torque[lane] = step(1, 2);
  parameters.velocity_from_command[lane] = step(1, 3);
  parameters.velocity_from_load[lane] = step(1, 4);
  parameters.torque_from_torque[lane] = step(2, 2);
  parameters.torque_from_command[lane] = step(2, 3);
  parameters.friction[lane] = (model.coulomb_friction + model.load_coulomb_friction * ratio) *
                              kUserUnitsPerRadian / inertia;
  parameters.friction_impulse[lane] =
      parameters.velocity_from_load[lane] * parameters.friction[lane];
}

void design_lane(const AxisModel& model, const Gear& gear, double substep, std::size_t lane,
                 ElasticParameters& parameters) {
  const double ratio = ratio_of(gear);
  design_loop(model, gear, substep, model.motor_inertia, whole_inertia(model, gear), lane,
              parameters.loop);
  const Elastic coupled = discretise<5, 3>(
      elastic_system(model, ratio, model.coupling_stiffness, model.coupling_damping), substep);
  const Elastic loose = discretise<5, 3>(elastic_system(model, ratio, 0.0, 0.0), substep);
  // The position of the load follows from motor and twist: x_l = r·x_m - twist. Its increment in a
  // sub-step is r·Δx_m - Δtwist, where the row of the twist gives the new twist, so the old one is
  // added back.
  using Increment = Eigen::Matrix<double, 1, 8>;
  const auto load_increment = [ratio](const Elastic& step) -> Increment {
    Increment row = ratio * step.row(column::motor_position) - step.row(column::twist);
    row(column::twist) += 1.0;
    return row;
  };
  set_row(coupled.row(column::motor_velocity), lane, parameters.motor_velocity);
  set_row(coupled.row(column::motor_position), lane, parameters.motor_position);
  set_row(coupled.row(column::load_velocity), lane, parameters.load_velocity);
  set_row(load_increment(coupled), lane, parameters.load_position);
  set_row(loose.row(column::motor_velocity), lane, parameters.free_motor_velocity);
  set_row(loose.row(column::motor_position), lane, parameters.free_motor_position);
  set_row(loose.row(column::load_velocity), lane, parameters.free_load_velocity);
  set_row(load_increment(loose), lane, parameters.free_load_position);
  parameters.torque_from_torque[lane] = coupled(column::torque, column::torque);
  parameters.torque_from_command[lane] = coupled(column::torque, column::command);
  parameters.half_backlash[lane] = 0.5 * model.backlash * kUserUnitsPerRadian;
  parameters.friction[lane] = model.coulomb_friction * kUserUnitsPerRadian / model.motor_inertia;
  parameters.load_friction[lane] =
      model.load_coulomb_friction * kUserUnitsPerRadian / model.load_inertia;
  parameters.friction_impulse[lane] =
      parameters.free_motor_velocity.motor_load[lane] * parameters.friction[lane];
  parameters.load_friction_impulse[lane] =
      parameters.free_load_velocity.load_load[lane] * parameters.load_friction[lane];
}

void limit_lane(const TorqueLimits& limits, double torque_unit, std::size_t lane,
                LoopParameters& loop) noexcept {
  loop.upper_limit[lane] = limits.positive / torque_unit;
  loop.lower_limit[lane] = -limits.negative / torque_unit;
}

}  // namespace vdrive
