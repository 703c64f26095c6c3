// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace vdrive {

/// Axes whose servo loops and physics are computed side by side.
inline constexpr std::size_t kLanes = 8;

/// Longest tick (10 ms) in servo cycles of 125 µs.
inline constexpr std::size_t kMaximumSubsteps = 80;

/// One double per axis of a block.
using Lane = std::array<double, kLanes>;

/// Servo loop settings of a block. Accelerations are torques over the motor's (two inertias) or the
/// whole (rigid) inertia, so that one unit serves loop, limits and plant.
struct alignas(64) LoopParameters {
  Lane position_gain;         // [1/s]
  Lane velocity_gain;         // [1/s]
  Lane integral_step;         // velocity integrator gain times the sub-step [1/s]
  Lane feed_forward;          // demand acceleration to motor acceleration [1]
  Lane upper_limit;           // [UU/s²]
  Lane lower_limit;           // [UU/s²] <= 0
  Lane ratio;                 // load over motor revolutions
  Lane inverse_ratio;         // position loop units to motor units
  Lane counts_per_unit;       // encoder 1 [counts/UU]
  Lane units_per_count;       // encoder 1 [UU/count]
  Lane load_counts_per_unit;  // encoder of the position loop [counts/UU]
  Lane load_units_per_count;  // encoder of the position loop [UU/count]
  Lane closes_on_load;        // 1 = the position loop uses encoder 2
};

/// One inertia: exact discretisation of v' = T - (b/J) v + d, T' = w (u - T).
struct alignas(64) RigidParameters {
  LoopParameters loop;
  Lane velocity_from_velocity;
  Lane velocity_from_torque;
  Lane velocity_from_command;
  Lane velocity_from_load;
  Lane position_from_velocity;
  Lane position_from_torque;
  Lane position_from_command;
  Lane position_from_load;
  Lane torque_from_torque;
  Lane torque_from_command;
  Lane friction;  // Coulomb friction [UU/s²]
};

/// Seven coefficients of one output of the elastic model.
struct ElasticRow {
  Lane twist;
  Lane motor_velocity;
  Lane load_velocity;
  Lane torque;
  Lane command;
  Lane motor_load;
  Lane load_load;
};

/// Two inertias on an elastic shaft, exactly discretised: the coupled system, and both inertias on
/// their own for the play of the backlash.
struct alignas(64) ElasticParameters {
  LoopParameters loop;
  ElasticRow motor_velocity;
  ElasticRow motor_position;
  ElasticRow load_velocity;
  ElasticRow load_position;
  ElasticRow free_motor_velocity;
  ElasticRow free_motor_position;
  ElasticRow free_load_velocity;
  ElasticRow free_load_position;
  Lane torque_from_torque;
  Lane torque_from_command;
  Lane half_backlash;  // [UU] at the load
  Lane friction;       // motor side [UU/s²]
  Lane load_friction;  // load side [UU/s²]
};

/// State of a block, and what acts on it from outside.
struct alignas(64) ServoState {
  Lane position;         // motor [UU], exact
  Lane velocity;         // motor [UU/s]
  Lane torque;           // of the current loop [UU/s²]
  Lane integrator;       // velocity loop [UU/s²]
  Lane measured;         // encoder 1 at the last sub-step [UU]
  Lane load_position;    // load [UU]; rigid: computed from the motor
  Lane load_velocity;    // load [UU/s]; rigid: unused
  Lane load_measured;    // encoder of the position loop at the last sub-step [UU]
  Lane load_offset;      // load position minus ratio times motor position, untwisted [UU]
  Lane load_torque;      // from outside, over the inertia that it acts on [UU/s²]
  Lane powered;          // 1 = power stage on
  Lane blocked;          // 1 = load blocked
  Lane speed_limit;      // of what the position loop asks for: 607Fh and 6080h [UU/s]
  Lane closes_position;  // 1 = position loop closed; general step only
  Lane torque_control;   // 1 = torque_wanted is the command, within speed_limit; general step only
  Lane torque_wanted;    // of the next sub-step [UU/s²]
  Lane torque_step;      // its change from one sub-step to the next [UU/s²]
  Lane command;          // last torque command [UU/s²]
  Lane motor_reading;    // encoder 1 at the end of the tick [UU]
  Lane load_reading;     // encoder of the position loop at the end of the tick [UU]
  Lane motor_speed;      // encoder 1 over the tick [UU/s]
  Lane load_speed;       // encoder of the position loop over the tick [UU/s]
};

/// Demand of one tick for a block: polynomial pieces and, from them, the values at each sub-step.
struct alignas(64) DemandBlock {
  Lane position;        // of the segment [UU]
  Lane velocity;        // of the segment [UU/s]
  Lane acceleration;    // of the segment [UU/s²]
  Lane reference_time;  // of the segment [s]
  Lane first_substep;   // since the plan, at the start of the tick
  std::array<Lane, kMaximumSubsteps> positions;
  std::array<Lane, kMaximumSubsteps> velocities;
  std::array<Lane, kMaximumSubsteps> accelerations;
};

/// Samples each lane's segment at the start of each sub-step.
void sample_demand(DemandBlock& demand, std::size_t substeps, double substep) noexcept;

/// One tick of servo loops and plant. `substep` is the length of a sub-step [s]. The general step
/// serves every kind of control; for lanes with closed position loop it gives the same bits as the
/// plain one, which serves only these.
void step_rigid(const RigidParameters& parameters, const DemandBlock& demand, ServoState& state,
                std::size_t substeps, double substep) noexcept;
void step_elastic(const ElasticParameters& parameters, const DemandBlock& demand, ServoState& state,
                  std::size_t substeps, double substep) noexcept;
void step_rigid_general(const RigidParameters& parameters, const DemandBlock& demand,
                        ServoState& state, std::size_t substeps, double substep) noexcept;
void step_elastic_general(const ElasticParameters& parameters, const DemandBlock& demand,
                          ServoState& state, std::size_t substeps, double substep) noexcept;

}  // namespace vdrive
