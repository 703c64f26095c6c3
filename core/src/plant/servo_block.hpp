// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lanes.hpp"
#include "vdrive/motion/jerk_profile.hpp"
#include "vdrive/motion/profile.hpp"

#include <cstddef>
#include <span>

namespace vdrive {

/// Number of blocks stepped together: a sub-step of one block mostly waits for its own results, and
/// the other blocks fill that time.
inline constexpr std::size_t kInterleavedBlocks = 4;

/// Servo loop settings of a block. Torques are expressed as accelerations: divided by the inertia
/// of the motor (two inertias) or the total inertia (rigid), so that loop, limits and plant share
/// one unit.
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
  Lane friction;          // Coulomb friction [UU/s²]
  Lane friction_impulse;  // change of velocity that it causes in a sub-step [UU/s]
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

/// Two inertias on an elastic shaft, exactly discretised: the coupled system, and the two inertias
/// separately for motion within the backlash.
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
  Lane half_backlash;          // [UU] at the load
  Lane friction;               // motor side [UU/s²]
  Lane load_friction;          // load side [UU/s²]
  Lane friction_impulse;       // change of velocity by `friction` in a sub-step [UU/s]
  Lane load_friction_impulse;  // the same for `load_friction`
};

/// State of a block and the external inputs that act on it.
struct alignas(64) ServoState {
  Lane position;         // motor [UU], exact
  Lane velocity;         // motor [UU/s]
  Lane torque;           // of the current loop [UU/s²]
  Lane integrator;       // velocity loop [UU/s²]
  Lane measured;         // encoder 1 at the last sub-step [UU]
  Lane load_position;    // load [UU]; rigid: computed from the motor
  Lane load_velocity;    // load [UU/s]; rigid: unused
  Lane load_offset;      // load position minus ratio times motor position, untwisted [UU]
  Lane load_torque;      // external, over the inertia that it acts on [UU/s²]
  Lane powered;          // 1 = power stage on
  Lane blocked;          // 1 = load blocked
  Lane speed_limit;      // limits the output of the position loop: 607Fh and 6080h [UU/s]
  Lane closes_position;  // 1 = position loop closed
  Lane torque_control;   // 1 = torque_wanted is the command, within speed_limit
  Lane torque_wanted;    // in the next sub-step [UU/s²]
  Lane torque_step;      // its change per sub-step [UU/s²]
  Lane command;          // last torque command [UU/s²]
  Lane motor_reading;    // encoder 1 at the end of the tick [UU]
  Lane load_reading;     // encoder of the position loop at the end of the tick [UU]
  Lane motor_speed;      // encoder 1 over the tick [UU/s]
  Lane load_speed;       // encoder of the position loop over the tick [UU/s]
};

/// Demand of a block: the segment in force in each lane, and the present state of its motion.
struct alignas(64) DemandBlock {
  Lane segment_position;      // at the reference [UU]
  Lane segment_velocity;      // at the reference [UU/s]
  Lane segment_acceleration;  // [UU/s²]
  Lane reference_time;        // [s] since the plan
  Lane end_time;              // of the segment [s] since the plan
  Lane plan_ticks;            // since the plan; but see SteadyBlock::standing
  Lane position;              // at the end of the last tick [UU]
  Lane velocity;              // at the end of the last tick [UU/s]
  Lane segment_jerk;          // 0 outside of BlockState::jerk_limited [UU/s³]
};

/// @return the segment in force in lane `l`, which has no jerk.
[[gnu::always_inline]] inline Segment segment_of(const DemandBlock& demand, std::size_t l) {
  return {.end_time = demand.end_time[l],
          .reference_time = demand.reference_time[l],
          .position = demand.segment_position[l],
          .velocity = demand.segment_velocity[l],
          .acceleration = demand.segment_acceleration[l]};
}

/// @return the segment in force in lane `l`.
[[gnu::always_inline]] inline JerkSegment jerk_segment_of(const DemandBlock& demand,
                                                          std::size_t l) {
  return {.end_time = demand.end_time[l],
          .reference_time = demand.reference_time[l],
          .position = demand.segment_position[l],
          .velocity = demand.segment_velocity[l],
          .acceleration = demand.segment_acceleration[l],
          .jerk = demand.segment_jerk[l]};
}

/// @return the demand of lane `l` at `time` [s] since its plan. In a lane without jerk the result
///         has the same bits with and without `kJerk`.
template <bool kJerk>
[[gnu::always_inline]] inline MotionSample sample_lane(const DemandBlock& demand, std::size_t l,
                                                       double time) {
  const MotionSample even = sample(segment_of(demand, l), time);
  if constexpr (!kJerk) return even;
  const MotionSample changing = sample(jerk_segment_of(demand, l), time);
  const bool has_jerk = demand.segment_jerk[l] != 0.0;
  return {has_jerk ? changing.position : even.position,
          has_jerk ? changing.velocity : even.velocity,
          has_jerk ? changing.acceleration : even.acceleration};
}

struct EffectBlock;  // plant/effects.hpp

/// A block for the kernel; equal blocks share their parameters.
template <typename Parameters>
struct ServoBlock {
  const Parameters* parameters = nullptr;
  const DemandBlock* demand = nullptr;
  ServoState* state = nullptr;
  EffectBlock* effects = nullptr;  // with ServoFeatures::effects
};

/// Sub-steps `first` to `last` - 1 of a tick of `count`, each of `length` [s].
struct Substeps {
  std::size_t first;
  std::size_t last;
  double count;
  double length;
};

/// @return whether all lanes have power, a load that can move, and a closed position loop.
[[nodiscard]] bool is_plain(const ServoState& state) noexcept;

/// The features that some blocks need in the servo step.
struct ServoFeatures {
  bool general = false;  // a block is not plain
  bool play = false;     // a block has backlash (two inertias)
  bool effects = false;  // all blocks have effects
  bool jerk = false;     // a lane follows a plan with jerk
};

/// Runs servo loops and plant of some blocks over some sub-steps of a tick, and reads the encoders
/// after the last sub-step of the tick. A feature changes no bit of a lane that does not use it.
void step_servo(std::span<const ServoBlock<RigidParameters>> blocks, const Substeps& substeps,
                ServoFeatures features) noexcept;
void step_servo(std::span<const ServoBlock<ElasticParameters>> blocks, const Substeps& substeps,
                ServoFeatures features) noexcept;

}  // namespace vdrive
