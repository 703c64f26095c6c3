// SPDX-License-Identifier: Apache-2.0
#include "vdrive/plant/loop_report.hpp"

#include "plant/servo_design.hpp"
#include "torque_limit.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <span>

namespace vdrive {
namespace {

using namespace literals;

constexpr double kLongestSubstep = 125.0e-6;  // [s]

// A slower oscillation counts as settling to rest, not as ringing [Hz].
constexpr double kLowestRinging = 0.05;

// An amplitude is down to 2 % after four time constants.
constexpr double kTimeConstants = 4.0;

using Row = Eigen::RowVectorXd;
using Matrix = Eigen::MatrixXd;

/// Output of the loops of lane 0 as a linear function of the states, one coefficient each; the same
/// computation as `control` in servo_kernel.cpp.
struct LoopOutput {
  Row error;    ///< of the velocity loop
  Row command;  ///< torque
};

/// The last three states are motor position, integrator, and motor position one sub-step earlier.
LoopOutput control_of(const LoopParameters& loop, const Row& measured, double substep) {
  const Eigen::Index motor = measured.size() - 3;
  LoopOutput control;
  control.error = -loop.position_gain[0] * loop.inverse_ratio[0] * measured;
  control.error(motor) -= 1.0 / substep;
  control.error(motor + 2) += 1.0 / substep;
  control.command = loop.velocity_gain[0] * control.error;
  control.command(motor + 1) += 1.0;
  return control;
}

void set_last_rows(const LoopParameters& loop, const LoopOutput& control, const Row& motor_step,
                   Matrix& step) {
  const Eigen::Index motor = step.rows() - 3;
  step.row(motor) = motor_step;
  step(motor, motor) += 1.0;
  step.row(motor + 1) = loop.integral_step[0] * control.error;
  step(motor + 1, motor + 1) += 1.0;
  step(motor + 2, motor) = 1.0;
}

/// One sub-step of loops and plant. States: velocity, torque, then those named at control_of.
Matrix step_of(const RigidParameters& p, double substep) {
  enum : Eigen::Index { velocity, torque, motor, integrator, before, count };

  Row measured = Row::Zero(count);
  measured(motor) = p.loop.closes_on_load[0] != 0.0 ? p.loop.ratio[0] : 1.0;
  const LoopOutput control = control_of(p.loop, measured, substep);
  const auto output = [&](double from_velocity, double from_torque, double from_command) -> Row {
    Row row = from_command * control.command;
    row(velocity) += from_velocity;
    row(torque) += from_torque;
    return row;
  };
  Matrix step = Matrix::Zero(count, count);
  step.row(velocity) =
      output(p.velocity_from_velocity[0], p.velocity_from_torque[0], p.velocity_from_command[0]);
  step.row(torque) = output(0.0, p.torque_from_torque[0], p.torque_from_command[0]);
  set_last_rows(
      p.loop, control,
      output(p.position_from_velocity[0], p.position_from_torque[0], p.position_from_command[0]),
      step);
  return step;
}

/// One sub-step of loops and plant. States: twist, velocities, torque, then those named at
/// control_of.
Matrix step_of(const ElasticParameters& p, double substep) {
  enum : Eigen::Index {
    twist,
    motor_velocity,
    load_velocity,
    torque,
    motor,
    integrator,
    before,
    count
  };

  const bool on_load = p.loop.closes_on_load[0] != 0.0;
  Row measured = Row::Zero(count);
  measured(motor) = on_load ? p.loop.ratio[0] : 1.0;
  measured(twist) = on_load ? -1.0 : 0.0;
  const LoopOutput control = control_of(p.loop, measured, substep);
  const auto output = [&](const ElasticRow& from) -> Row {
    Row row = from.command[0] * control.command;
    row(twist) += from.twist[0];
    row(motor_velocity) += from.motor_velocity[0];
    row(load_velocity) += from.load_velocity[0];
    row(torque) += from.torque[0];
    return row;
  };
  const Row motor_step = output(p.motor_position);
  Matrix step = Matrix::Zero(count, count);
  step.row(twist) = p.loop.ratio[0] * motor_step - output(p.load_position);
  step(twist, twist) += 1.0;
  step.row(motor_velocity) = output(p.motor_velocity);
  step.row(load_velocity) = output(p.load_velocity);
  step.row(torque) = p.torque_from_command[0] * control.command;
  step(torque, torque) += p.torque_from_torque[0];
  set_last_rows(p.loop, control, motor_step, step);
  return step;
}

void find_ringing(const Matrix& step, double substep, double highest, LoopReport& report) {
  const Eigen::EigenSolver<Matrix> solver(step, false);
  // The poles in continuous time [1/s].
  const Eigen::ArrayXcd poles = solver.eigenvalues().array().log() / substep;
  double slowest = std::numeric_limits<double>::infinity();
  for (const std::complex<double>& pole : poles) {
    const double frequency = pole.imag() / kTwoPi;
    const double decay_rate = -pole.real();
    if (frequency < kLowestRinging || frequency > highest || decay_rate >= slowest) continue;
    slowest = decay_rate;
    report.ringing = frequency;
    report.ringing_time =
        decay_rate > 0.0 ? kTimeConstants / decay_rate : std::numeric_limits<double>::infinity();
  }
}

template <typename Parameters>
void examine(const AxisModel& model, const Gear& gear, double substep, LoopReport& report) {
  const auto parameters = std::make_unique<Parameters>();
  design_lane(model, gear, substep, 0, *parameters);
  const LoopParameters& loop = parameters->loop;
  const double unit = torque_unit(model, gear);
  const double loop_inertia_ratio = loop.feed_forward[0] / loop.inverse_ratio[0];
  report.velocity_bandwidth = loop.velocity_gain[0] / loop_inertia_ratio / kTwoPi;
  report.position_bandwidth = loop.position_gain[0] / kTwoPi;
  report.torque_needed *= loop.feed_forward[0] * unit;
  find_ringing(step_of(*parameters, substep), substep, 2.0 * model.velocity_loop_bandwidth, report);
}

}  // namespace

LoopReport examine_loops(const AxisConfiguration& axis, std::chrono::microseconds period) {
  const AxisBank bank(std::span(&axis, 1), period);
  const auto value = [&bank](ObjectRow row) {
    return static_cast<double>(bank.read(0, row).value);
  };
  const AxisModel& model = axis.model;
  const Gear gear{static_cast<std::uint32_t>(value("gear_ratio_numerator"_object)),
                  static_cast<std::uint32_t>(value("gear_ratio_denominator"_object))};
  const double seconds = std::chrono::duration<double>(period).count();
  const double substep = seconds / std::ceil(seconds / kLongestSubstep - 1.0e-9);
  const double rated = value("motor_rated_torque"_object) * 1.0e-3;
  const double unit =
      std::min(rated, value("motor_rated_current"_object) * 1.0e-3 * model.torque_constant);
  const auto limit = [&](ObjectRow relative) {
    return torque_limit(value("max_torque"_object) * 1.0e-3 * rated, value(relative) * 1.0e-3,
                        unit);
  };
  LoopReport report;
  report.gear_ratio = ratio_of(gear);
  report.inertia_ratio =
      1.0 + model.load_inertia * report.gear_ratio * report.gear_ratio / model.motor_inertia;
  report.torque_limit = std::min(limit("positive_torque_limit_relative"_object),
                                 limit("negative_torque_limit_relative"_object));
  report.torque_needed =  // still [UU/s²] here
      std::max(std::min(value("profile_acc"_object), value("app_acc_limit"_object)),
               std::min(value("profile_dec"_object), value("app_dec_limit"_object)));
  if (model.coupling == Coupling::rigid) {
    examine<RigidParameters>(model, gear, substep, report);
  } else {
    report.load_resonance = std::sqrt(model.coupling_stiffness / model.load_inertia) / kTwoPi;
    examine<ElasticParameters>(model, gear, substep, report);
  }
  return report;
}

}  // namespace vdrive
