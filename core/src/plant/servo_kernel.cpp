// SPDX-License-Identifier: Apache-2.0
#include "plant/effects.hpp"
#include "plant/load_noise.hpp"
#include "plant/readings.hpp"
#include "plant/servo_block.hpp"
#include "scramble.hpp"
#include "vdrive/motion/profile.hpp"
#include "vdrive/plant/axis_model.hpp"

namespace vdrive {
namespace {

[[gnu::always_inline]] inline double clamp(double x, double lower, double upper) {
  const double below_upper = x > upper ? upper : x;
  return below_upper < lower ? lower : below_upper;
}

/// Torque command in torque control: the wanted torque, reduced near the speed limit. It is limited
/// to the torque that the proportional part of the velocity loop would command with the speed limit
/// as its demand, so the speed stays below that limit.
[[gnu::always_inline]] inline double torque_within_speed(const LoopParameters& p, ServoState& s,
                                                         std::size_t l, double measured_velocity) {
  const double most = s.speed_limit[l] * p.inverse_ratio[l];
  const double wanted = s.torque_wanted[l];
  s.torque_wanted[l] = wanted + s.torque_step[l];
  return clamp(wanted, p.velocity_gain[l] * (-most - measured_velocity),
               p.velocity_gain[l] * (most - measured_velocity));
}

/// Torque command: position P within the speed limit, velocity PI with feed-forward, clamped with
/// anti-windup. With `kGeneral` the power stage may be off, the position loop open, or the torque
/// commanded directly; in torque control the integrator follows the command, so that the velocity
/// loop takes over without a step.
template <bool kGeneral>
[[gnu::always_inline]] inline double control(const LoopParameters& p, ServoState& s, std::size_t l,
                                             const MotionSample& demand, double measured,
                                             double load_measured, double rate) {
  const double measured_velocity = (measured - s.measured[l]) * rate;
  const double closed = kGeneral ? s.closes_position[l] : 1.0;
  const double correction = p.position_gain[l] * (demand.position - load_measured) * closed;
  const double free_speed = correction + demand.velocity;
  const double speed = clamp(free_speed, -s.speed_limit[l], s.speed_limit[l]);
  const double wanted = speed * p.inverse_ratio[l];
  const double error = wanted - measured_velocity;
  const double speed_command =
      p.velocity_gain[l] * error + s.integrator[l] + p.feed_forward[l] * demand.acceleration;
  const bool by_torque = kGeneral && s.torque_control[l] != 0.0;
  const double torque_command = kGeneral ? torque_within_speed(p, s, l, measured_velocity) : 0.0;
  const double free_command = by_torque ? torque_command : speed_command;
  const double command = clamp(free_command, p.lower_limit[l], p.upper_limit[l]);
  const bool winds_up = (free_command - command) * error > 0.0;
  const double powered = kGeneral ? s.powered[l] : 1.0;
  const double integral = s.integrator[l] + (winds_up ? 0.0 : p.integral_step[l] * error);
  s.integrator[l] = (by_torque ? command : integral) * powered;
  s.measured[l] = measured;
  s.command[l] = command * powered;
  return s.command[l];
}

/// Reads the encoders at the end of the tick and computes the speeds over it.
template <bool kEffects>
[[gnu::always_inline]] inline void read_encoders(const LoopParameters& p, ServoState& s,
                                                 const EffectBlock* e, std::size_t l,
                                                 double tick_rate) {
  const EncoderReadings readings = read_lane<kEffects>(p, s, e, l);
  s.motor_speed[l] = (readings.motor - s.motor_reading[l]) * tick_rate;
  s.load_speed[l] = (readings.load - s.load_reading[l]) * tick_rate;
  s.motor_reading[l] = readings.motor;
  s.load_reading[l] = readings.load;
}

/// Velocity after a sub-step with Coulomb friction: `free_velocity` is the result without it,
/// `impulse` >= 0 its effect. A reversal ends at 0, where only a torque greater than the friction
/// breaks away.
struct Friction {
  double velocity;
  double direction;  // opposed by friction
  bool stuck;
};

[[gnu::always_inline]] inline Friction apply_friction(double velocity, double free_velocity,
                                                      double impulse) {
  const double moving = velocity != 0.0 ? velocity : free_velocity;
  const double direction = __builtin_copysign(moving != 0.0 ? 1.0 : 0.0, moving);
  const double next = free_velocity - direction * impulse;
  const bool stuck = (next * direction <= 0.0) & (impulse > 0.0);
  return {stuck ? 0.0 : next, direction, stuck};
}

/// Torque of the motor in a sub-step.
template <bool kGeneral>
[[gnu::always_inline]] inline double torque_of(const ServoState& s, std::size_t l) {
  return kGeneral ? s.torque[l] * s.powered[l] : s.torque[l];
}

/// The torque that cogging and ripple add in a sub-step: +0 in a lane without either. Most blocks
/// have no ripple, so its sine has its own loop.
template <bool kGeneral>
[[gnu::always_inline]] inline void find_ripple_torque(const EffectBlock& e, const ServoState& s,
                                                      Lane& uneven) {
  const EffectParameters& p = e.parameters;
  uneven = {};
  if (p.cogged != 0) {
    VDRIVE_INDEPENDENT_LANES
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double angle = s.position[l] - e.state.motor_origin[l];
      // + 0.0 turns -0 into +0: a -0 would change the sign of another 0.
      uneven[l] = p.cogging[l] * sine_of_turns(angle * p.cogging_turns[l]) + 0.0;
    }
  }
  if (p.rippled != 0) {
    VDRIVE_INDEPENDENT_LANES
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double angle = s.position[l] - e.state.motor_origin[l];
      const double ripple = p.ripple[l] * sine_of_turns(angle * p.ripple_turns[l]);
      uneven[l] += torque_of<kGeneral>(s, l) * ripple;
    }
  }
}

/// @return `torque` plus the torque of cogging and ripple; bit-identical if that is 0.
[[gnu::always_inline]] inline double add_ripple_torque(double torque, double uneven) {
  return uneven != 0.0 ? torque + uneven : torque;
}

/// @return where a step from `from` to `to` ends for a load with end stops: it stays at a stop,
///         without rebound; from beyond a stop it can only move back.
[[gnu::always_inline]] inline double between_stops(const EffectState& s, std::size_t l, double from,
                                                   double to) {
  const double highest = from > s.upper_stop[l] ? from : s.upper_stop[l];
  const double lowest = from < s.lower_stop[l] ? from : s.lower_stop[l];
  return clamp(to, lowest, highest);
}

/// Draws the noise of the next encoder readings.
[[gnu::always_inline]] inline void draw_noise(EffectBlock& e) {
  EffectState& s = e.state;
  if (s.noisy == 0) return;
  s.draws += 2U;  // one for each encoder
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double motor = e.parameters.motor_noise[l] * noise_of(scramble(s.streams[l] + s.draws));
    const double load =
        e.parameters.load_noise[l] * noise_of(scramble(s.streams[l] + s.draws + 1U));
    s.motor_noise[l] = motor;
    s.load_noise[l] = e.parameters.shares_encoder[l] != 0.0 ? motor : load;
  }
}

/// One increment of the elastic model: velocities and steps of motor and load.
struct ElasticStep {
  double motor_velocity;
  double motor_step;
  double load_velocity;
  double load_step;
};

/// The inputs of one sub-step of the elastic model in lane `l`.
struct ElasticInput {
  std::size_t l;
  double strain;
  double motor_velocity;
  double load_velocity;
  double torque;
  double command;
};

[[gnu::always_inline]] inline double apply(const ElasticRow& row, const ElasticInput& in,
                                           double motor_load, double load_load) {
  return row.twist[in.l] * in.strain + row.motor_velocity[in.l] * in.motor_velocity +
         row.load_velocity[in.l] * in.load_velocity + row.torque[in.l] * in.torque +
         row.command[in.l] * in.command + row.motor_load[in.l] * motor_load +
         row.load_load[in.l] * load_load;
}

[[gnu::always_inline]] inline double coupled(const ElasticRow& engaged, const ElasticRow& loose,
                                             bool is_engaged, const ElasticInput& in,
                                             double motor_load, double load_load) {
  const double with_shaft = apply(engaged, in, motor_load, load_load);
  const double without = apply(loose, in, motor_load, load_load);
  return is_engaged ? with_shaft : without;
}

/// Friction of the brake in a sub-step: all of it if the motor slips, otherwise as much as it takes
/// to hold the motor. The linear model would apply all of it over the sub-step and pass the excess
/// on through the shaft; the load would then hang on the brake instead of on the shaft.
[[gnu::always_inline]] inline double brake_friction(const ElasticParameters& p,
                                                    const EffectBlock& e, std::size_t l,
                                                    double free_velocity,
                                                    const Friction& on_motor) {
  const double missing = on_motor.direction * free_velocity - p.friction_impulse[l];
  const double held = (missing > 0.0 ? missing : 0.0) / p.free_motor_velocity.motor_load[l];
  return on_motor.stuck ? held : e.state.brake[l];
}

/// Linear step, then Coulomb friction on both sides: against the present velocity or, from
/// standstill, against the velocity that would follow without friction.
/// @param uneven torque that cogging and ripple add to that of the motor
template <bool kEffects>
[[gnu::always_inline]] inline ElasticStep advance(const ElasticParameters& p, const EffectBlock* e,
                                                  const ElasticInput& in, bool engaged, double load,
                                                  double uneven, double half_substep) {
  const std::size_t l = in.l;
  const double impulse =
      kEffects ? p.friction_impulse[l] + e->state.brake_impulse[l] : p.friction_impulse[l];
  const double free_velocity =
      coupled(p.motor_velocity, p.free_motor_velocity, engaged, in, uneven, load);
  const Friction on_motor = apply_friction(in.motor_velocity, free_velocity, impulse);
  const double friction =
      kEffects ? p.friction[l] + brake_friction(p, *e, l, free_velocity, on_motor) : p.friction[l];
  const Friction on_load = apply_friction(
      in.load_velocity, coupled(p.load_velocity, p.free_load_velocity, engaged, in, 0.0, load),
      p.load_friction_impulse[l]);
  const double rubbed = -on_motor.direction * friction;
  const double dm = kEffects ? add_ripple_torque(rubbed, uneven) : rubbed;
  const double dl = load - on_load.direction * p.load_friction[l];
  const double vm = coupled(p.motor_velocity, p.free_motor_velocity, engaged, in, dm, dl);
  const double xm = coupled(p.motor_position, p.free_motor_position, engaged, in, dm, dl);
  const double vl = coupled(p.load_velocity, p.free_load_velocity, engaged, in, dm, dl);
  const double xl = coupled(p.load_position, p.free_load_position, engaged, in, dm, dl);
  return {on_motor.stuck ? 0.0 : vm, on_motor.stuck ? half_substep * in.motor_velocity : xm,
          on_load.stuck ? 0.0 : vl, on_load.stuck ? half_substep * in.load_velocity : xl};
}

template <bool kGeneral, bool kPlay, bool kEffects>
[[gnu::always_inline]] inline void step_elastic_lane(const ElasticParameters& p, ServoState& state,
                                                     const EffectBlock* e, std::size_t l,
                                                     const MotionSample& demand, double uneven,
                                                     double rate, double half_substep) {
  const double xm = state.position[l];
  const double xl = state.load_position[l];
  const double measured = quantise(seen_by_motor<kEffects>(e, l, xm), p.loop.counts_per_unit[l],
                                   p.loop.units_per_count[l]);
  const double load_measured =
      quantise(seen_by_load<kEffects>(e, l, p.loop.closes_on_load[l] != 0.0 ? xl : xm),
               p.loop.load_counts_per_unit[l], p.loop.load_units_per_count[l]);
  const double u = control<kGeneral>(p.loop, state, l, demand, measured, load_measured, rate);
  const double torque = torque_of<kGeneral>(state, l);

  // Within the backlash the inertias are separate; outside it the rest of the twist strains the
  // shaft.
  const double twist = p.loop.ratio[l] * xm + state.load_offset[l] - xl;
  const double play = kPlay ? p.half_backlash[l] : 0.0;
  const double below = twist > play ? play : twist;
  const double strain = twist - (below < -play ? -play : below);
  const bool engaged = !kPlay || ((strain != 0.0) | (play == 0.0));

  const ElasticInput in{l, strain, state.velocity[l], state.load_velocity[l], torque, u};
  const ElasticStep next =
      advance<kEffects>(p, e, in, engaged, state.load_torque[l], uneven, half_substep);
  const bool blocked = kGeneral && state.blocked[l] != 0.0;
  state.position[l] = xm + next.motor_step;
  state.velocity[l] = next.motor_velocity;
  state.load_position[l] = blocked ? xl : xl + next.load_step;
  state.load_velocity[l] = blocked ? 0.0 : next.load_velocity;
  state.torque[l] = p.torque_from_torque[l] * torque + p.torque_from_command[l] * u;
}

/// Applies the end stops to a step of a rigid axis whose motor started at `x`.
[[gnu::always_inline]] inline void hold_lane(const RigidParameters& p, const EffectBlock& e,
                                             ServoState& state, std::size_t l, double x) {
  const double load_x = p.loop.ratio[l] * x + state.load_offset[l];
  const double moved = p.loop.ratio[l] * state.position[l] + state.load_offset[l];
  const double end = between_stops(e.state, l, load_x, moved);
  const double at_stop = (end - state.load_offset[l]) * e.parameters.motor_per_load[l];
  // At a stop the bits stay the same: converting to the load and back would round.
  const double held = end == load_x ? x : at_stop;
  const bool caught = end != moved;
  state.position[l] = caught ? held : state.position[l];
  state.velocity[l] = caught ? 0.0 : state.velocity[l];
}

/// Applies the end stops to a step of a load on a shaft that started at `x`.
[[gnu::always_inline]] inline void hold_lane(const ElasticParameters& /*p*/, const EffectBlock& e,
                                             ServoState& state, std::size_t l, double x) {
  const double moved = state.load_position[l];
  const double end = between_stops(e.state, l, x, moved);
  state.load_position[l] = end;
  state.load_velocity[l] = end != moved ? 0.0 : state.load_velocity[l];
}

/// Applies the end stops to a block whose steps started at `begin`.
template <typename Parameters>
[[gnu::always_inline]] inline void hold_at_stops(const Parameters& p, const EffectBlock& e,
                                                 ServoState& state, const Lane& begin) {
  if (e.parameters.stopped == 0) return;
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) hold_lane(p, e, state, l, begin[l]);
}

/// @return the positions before a step, as hold_lane() needs them.
[[gnu::always_inline]] inline const Lane& begin_of(const RigidParameters& /*p*/,
                                                   const ServoState& state) {
  return state.position;
}

[[gnu::always_inline]] inline const Lane& begin_of(const ElasticParameters& /*p*/,
                                                   const ServoState& state) {
  return state.load_position;
}

template <bool kGeneral, bool kEffects>
[[gnu::always_inline]] inline void step_rigid_lane(const RigidParameters& p, ServoState& state,
                                                   const EffectBlock* e, std::size_t l,
                                                   const MotionSample& demand, double uneven,
                                                   double rate, double half_substep) {
  const double x = state.position[l];
  const double v = state.velocity[l];
  const double measured = quantise(seen_by_motor<kEffects>(e, l, x), p.loop.counts_per_unit[l],
                                   p.loop.units_per_count[l]);
  const double load_x = p.loop.ratio[l] * x + state.load_offset[l];
  const double load_measured =
      quantise(seen_by_load<kEffects>(e, l, p.loop.closes_on_load[l] != 0.0 ? load_x : x),
               p.loop.load_counts_per_unit[l], p.loop.load_units_per_count[l]);
  const double u = control<kGeneral>(p.loop, state, l, demand, measured, load_measured, rate);
  const double torque = torque_of<kGeneral>(state, l);
  const double outside = state.load_torque[l];
  const double load = kEffects ? add_ripple_torque(outside, uneven) : outside;
  const double rubbing = kEffects ? p.friction[l] + e->state.brake[l] : p.friction[l];
  const double impulse =
      kEffects ? p.friction_impulse[l] + e->state.brake_impulse[l] : p.friction_impulse[l];
  const double free_velocity = p.velocity_from_velocity[l] * v +
                               p.velocity_from_torque[l] * torque + p.velocity_from_command[l] * u +
                               p.velocity_from_load[l] * load;
  const Friction friction = apply_friction(v, free_velocity, impulse);
  const double moved = x + p.position_from_velocity[l] * v + p.position_from_torque[l] * torque +
                       p.position_from_command[l] * u +
                       p.position_from_load[l] * (load - friction.direction * rubbing);
  const double next = friction.stuck ? x + half_substep * v : moved;
  const bool blocked = kGeneral && state.blocked[l] != 0.0;
  state.position[l] = blocked ? x : next;
  state.velocity[l] = blocked ? 0.0 : friction.velocity;
  state.torque[l] = p.torque_from_torque[l] * torque + p.torque_from_command[l] * u;
}

/// The demand of lane `l` at sub-step `k` of the tick.
template <bool kJerk>
[[gnu::always_inline]] inline MotionSample demand_at(const DemandBlock& demand, std::size_t l,
                                                     const Substeps& substeps, double k) {
  const double first = demand.plan_ticks[l] * substeps.count;
  return sample_lane<kJerk>(demand, l, (first + k) * substeps.length);
}

/// Limits every motor to kHighestMotorSpeed, whatever drives it.
[[gnu::always_inline]] inline void bound_speed(const RigidParameters& /*p*/, ServoState& s,
                                               std::size_t l) {
  s.velocity[l] = clamp(s.velocity[l], -kHighestMotorSpeed, kHighestMotorSpeed);
}

[[gnu::always_inline]] inline void bound_speed(const ElasticParameters& p, ServoState& s,
                                               std::size_t l) {
  const double highest_of_load = kHighestMotorSpeed * p.loop.ratio[l];
  s.velocity[l] = clamp(s.velocity[l], -kHighestMotorSpeed, kHighestMotorSpeed);
  s.load_velocity[l] = clamp(s.load_velocity[l], -highest_of_load, highest_of_load);
}

template <bool kEffects, typename Parameters>
[[gnu::always_inline]] inline void end_tick(const ServoBlock<Parameters>& block, double tick_rate) {
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    bound_speed(*block.parameters, *block.state, l);
    place_load(*block.parameters, *block.state, l);
    read_encoders<kEffects>(block.parameters->loop, *block.state, block.effects, l, tick_rate);
  }
}

/// One sub-step of the lanes of a block. Work that only some blocks with effects need is in
/// separate loops.
template <bool kGeneral, bool kEffects, bool kJerk, typename Parameters, typename StepLane>
[[gnu::always_inline]] inline void step_block(const ServoBlock<Parameters>& block,
                                              const Substeps& substeps, double k,
                                              StepLane step_lane) {
  const Parameters& parameters = *block.parameters;
  ServoState& state = *block.state;
  Lane uneven{};
  Lane begin{};
  if constexpr (kEffects) {
    find_ripple_torque<kGeneral>(*block.effects, state, uneven);
    begin = begin_of(parameters, state);
  }
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    step_lane(block, l, demand_at<kJerk>(*block.demand, l, substeps, k), uneven[l]);
  }
  if constexpr (kEffects) {
    hold_at_stops(parameters, *block.effects, state, begin);
    draw_noise(*block.effects);
  }
}

/// Interleaves the sub-steps of the blocks, so that `step_lane(block, lane, demand, uneven)` of one
/// block does not wait for that of another.
template <bool kGeneral, bool kEffects, bool kJerk, typename Parameters, typename StepLane>
[[gnu::always_inline]] inline void step_blocks(std::span<const ServoBlock<Parameters>> blocks,
                                               const Substeps& substeps, StepLane step_lane) {
  for (std::size_t k = substeps.first; k < substeps.last; ++k) {
    const auto step = static_cast<double>(k);
    for (const ServoBlock<Parameters>& block : blocks) {
      step_block<kGeneral, kEffects, kJerk>(block, substeps, step, step_lane);
    }
  }
  if (static_cast<double>(substeps.last) != substeps.count) return;
  const double tick_rate = 1.0 / (substeps.count * substeps.length);
  for (const ServoBlock<Parameters>& block : blocks) end_tick<kEffects>(block, tick_rate);
}

template <bool kGeneral, bool kEffects, bool kJerk>
[[gnu::always_inline]] inline void step_rigid(std::span<const ServoBlock<RigidParameters>> blocks,
                                              const Substeps& substeps) {
  const double rate = 1.0 / substeps.length;
  const double half_substep = 0.5 * substeps.length;
  step_blocks<kGeneral, kEffects, kJerk>(
      blocks, substeps,
      [=](const ServoBlock<RigidParameters>& block, std::size_t l, const MotionSample& demand,
          double uneven) __attribute__((always_inline)) {
        step_rigid_lane<kGeneral, kEffects>(*block.parameters, *block.state, block.effects, l,
                                            demand, uneven, rate, half_substep);
      });
}

template <bool kGeneral, bool kPlay, bool kEffects, bool kJerk>
[[gnu::always_inline]] inline void step_elastic(
    std::span<const ServoBlock<ElasticParameters>> blocks, const Substeps& substeps) {
  const double rate = 1.0 / substeps.length;
  const double half_substep = 0.5 * substeps.length;
  step_blocks<kGeneral, kEffects, kJerk>(
      blocks, substeps,
      [=](const ServoBlock<ElasticParameters>& block, std::size_t l, const MotionSample& demand,
          double uneven) __attribute__((always_inline)) {
        step_elastic_lane<kGeneral, kPlay, kEffects>(*block.parameters, *block.state, block.effects,
                                                     l, demand, uneven, rate, half_substep);
      });
}

VDRIVE_VECTOR_CLONES
void rigid_plain(std::span<const ServoBlock<RigidParameters>> blocks, const Substeps& substeps) {
  step_rigid<false, false, false>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void rigid_jerk(std::span<const ServoBlock<RigidParameters>> blocks, const Substeps& substeps) {
  step_rigid<false, false, true>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void rigid_general(std::span<const ServoBlock<RigidParameters>> blocks, const Substeps& substeps) {
  step_rigid<true, false, false>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void rigid_general_jerk(std::span<const ServoBlock<RigidParameters>> blocks,
                        const Substeps& substeps) {
  step_rigid<true, false, true>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void rigid_effects(std::span<const ServoBlock<RigidParameters>> blocks, const Substeps& substeps) {
  step_rigid<false, true, false>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void rigid_general_effects(std::span<const ServoBlock<RigidParameters>> blocks,
                           const Substeps& substeps) {
  step_rigid<true, true, false>(blocks, substeps);
}

/// Effects with jerk have only this variant: for a plain block the general one gives the same bits.
VDRIVE_VECTOR_CLONES
void rigid_effects_jerk(std::span<const ServoBlock<RigidParameters>> blocks,
                        const Substeps& substeps) {
  step_rigid<true, true, true>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void elastic_plain(std::span<const ServoBlock<ElasticParameters>> blocks,
                   const Substeps& substeps) {
  step_elastic<false, false, false, false>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void elastic_jerk(std::span<const ServoBlock<ElasticParameters>> blocks, const Substeps& substeps) {
  step_elastic<false, false, false, true>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void elastic_general(std::span<const ServoBlock<ElasticParameters>> blocks,
                     const Substeps& substeps) {
  step_elastic<true, true, false, false>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void elastic_general_jerk(std::span<const ServoBlock<ElasticParameters>> blocks,
                          const Substeps& substeps) {
  step_elastic<true, true, false, true>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void elastic_effects(std::span<const ServoBlock<ElasticParameters>> blocks,
                     const Substeps& substeps) {
  step_elastic<false, false, true, false>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void elastic_general_effects(std::span<const ServoBlock<ElasticParameters>> blocks,
                             const Substeps& substeps) {
  step_elastic<true, true, true, false>(blocks, substeps);
}

VDRIVE_VECTOR_CLONES
void elastic_effects_jerk(std::span<const ServoBlock<ElasticParameters>> blocks,
                          const Substeps& substeps) {
  step_elastic<true, true, true, true>(blocks, substeps);
}

}  // namespace

VDRIVE_VECTOR_CLONES
bool is_plain(const ServoState& state) noexcept {
  std::uint64_t others = 0;
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    const bool powered = state.powered[l] == 1.0;
    const bool moves = state.blocked[l] == 0.0;
    const bool closed = state.closes_position[l] == 1.0;
    const bool by_position = state.torque_control[l] == 0.0;
    const bool plain = powered & moves & closed & by_position;
    others |= plain ? 0U : 1U;
  }
  return others == 0;
}

void step_servo(std::span<const ServoBlock<RigidParameters>> blocks, const Substeps& substeps,
                ServoFeatures features) noexcept {
  auto* step = features.general ? rigid_general : rigid_plain;
  if (features.effects) {
    step = features.general ? rigid_general_effects : rigid_effects;
    if (features.jerk) step = rigid_effects_jerk;
  } else if (features.jerk) {
    step = features.general ? rigid_general_jerk : rigid_jerk;
  }
  step(blocks, substeps);
}

void step_servo(std::span<const ServoBlock<ElasticParameters>> blocks, const Substeps& substeps,
                ServoFeatures features) noexcept {
  const bool is_general = features.general || features.play;
  auto* step = is_general ? elastic_general : elastic_plain;
  if (features.effects) {
    step = is_general ? elastic_general_effects : elastic_effects;
    if (features.jerk) step = elastic_effects_jerk;
  } else if (features.jerk) {
    step = is_general ? elastic_general_jerk : elastic_jerk;
  }
  step(blocks, substeps);
}

}  // namespace vdrive
