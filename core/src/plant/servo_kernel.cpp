// SPDX-License-Identifier: Apache-2.0
//
// The hot loops: plain loops over lanes that the compiler vectorises for each instruction set. Only
// + - * / and comparisons, no contraction, no sum across lanes: the same bits for every width.
#include "plant/servo_block.hpp"
#include "vdrive/motion/profile.hpp"

// Sanitizer runtimes are not ready when the loader resolves the clones.
#if defined(__x86_64__) && !defined(VDRIVE_NO_TARGET_CLONES)
#define VDRIVE_VECTOR_CLONES \
  __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define VDRIVE_VECTOR_CLONES
#endif

#if defined(VDRIVE_NO_TARGET_CLONES)
#define VDRIVE_INDEPENDENT_LANES
#elif defined(__clang__)
#define VDRIVE_INDEPENDENT_LANES _Pragma("clang loop vectorize(assume_safety)")
#else
#define VDRIVE_INDEPENDENT_LANES _Pragma("GCC ivdep")
#endif

namespace vdrive {
namespace {

/// Adding and subtracting 1.5·2⁵² rounds to the nearest integer for |x| < 2⁵¹ on every unit.
constexpr double kRounder = 6755399441055744.0;

[[gnu::always_inline]] inline double quantise(double x, double per_unit, double unit) {
  return ((x * per_unit + kRounder) - kRounder) * unit;
}

[[gnu::always_inline]] inline double clamp(double x, double lower, double upper) {
  const double below_upper = x > upper ? upper : x;
  return below_upper < lower ? lower : below_upper;
}

/// Torque command of profile torque: the wanted torque, taken back where the speed limit is near.
/// The velocity loop's proportional part for the limit bounds it, so the speed stays below.
[[gnu::always_inline]] inline double torque_within_speed(const LoopParameters& p, ServoState& s,
                                                         std::size_t l, double measured_velocity) {
  const double most = s.speed_limit[l] * p.inverse_ratio[l];
  const double wanted = s.torque_wanted[l];
  s.torque_wanted[l] = wanted + s.torque_step[l];
  return clamp(wanted, p.velocity_gain[l] * (-most - measured_velocity),
               p.velocity_gain[l] * (most - measured_velocity));
}

/// Position P within the speed limit, velocity PI with feed-forward, clamped without wind-up: the
/// torque command. `kGeneral`: the position loop may be open, or the torque asked for directly; its
/// integrator then follows the command, so that the velocity loop takes over without a step.
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
  const double powered = s.powered[l];
  const double integral = s.integrator[l] + (winds_up ? 0.0 : p.integral_step[l] * error);
  s.integrator[l] = (by_torque ? command : integral) * powered;
  s.measured[l] = measured;
  s.load_measured[l] = load_measured;
  s.command[l] = command * powered;
  return s.command[l];
}

/// Encoder readings at the end of the tick, and the speeds that they give over it.
[[gnu::always_inline]] inline void read_encoders(const LoopParameters& p, ServoState& s,
                                                 std::size_t l, double tick_rate) {
  const double motor = quantise(s.position[l], p.counts_per_unit[l], p.units_per_count[l]);
  const double load = quantise(p.closes_on_load[l] != 0.0 ? s.load_position[l] : s.position[l],
                               p.load_counts_per_unit[l], p.load_units_per_count[l]);
  s.motor_speed[l] = (motor - s.motor_reading[l]) * tick_rate;
  s.load_speed[l] = (load - s.load_reading[l]) * tick_rate;
  s.motor_reading[l] = motor;
  s.load_reading[l] = load;
}

/// Velocity after a sub-step with Coulomb friction: `free_velocity` is the result without it,
/// `impulse` >= 0 its effect. A reversal ends at 0; from 0 only a larger torque breaks away.
struct Friction {
  double velocity;
  double direction;  // that friction opposed
  bool stuck;
};

[[gnu::always_inline]] inline Friction rub(double velocity, double free_velocity, double impulse) {
  const double moving = velocity != 0.0 ? velocity : free_velocity;
  const double direction = moving > 0.0 ? 1.0 : (moving < 0.0 ? -1.0 : 0.0);
  const double next = free_velocity - direction * impulse;
  const bool stuck = (next * direction <= 0.0) & (impulse > 0.0);
  return {stuck ? 0.0 : next, direction, stuck};
}

}  // namespace

VDRIVE_VECTOR_CLONES
void sample_demand(DemandBlock& demand, std::size_t substeps, double substep) noexcept {
  for (std::size_t k = 0; k < substeps; ++k) {
    const auto step = static_cast<double>(k);
    VDRIVE_INDEPENDENT_LANES
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double tau = (demand.first_substep[l] + step) * substep - demand.reference_time[l];
      demand.positions[k][l] =
          demand.position[l] + (demand.velocity[l] + 0.5 * demand.acceleration[l] * tau) * tau;
      demand.velocities[k][l] = demand.velocity[l] + demand.acceleration[l] * tau;
      demand.accelerations[k][l] = demand.acceleration[l];
    }
  }
}

namespace {

/// One increment of the elastic model: velocities and steps of motor and load.
struct ElasticStep {
  double motor_velocity;
  double motor_step;
  double load_velocity;
  double load_step;
};

/// What drives one sub-step of the elastic model in lane `l`.
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

/// Linear step, then Coulomb friction on both sides: the velocities without it tell which way it
/// acts.
[[gnu::always_inline]] inline ElasticStep advance(const ElasticParameters& p,
                                                  const ElasticInput& in, bool engaged, double load,
                                                  double half_substep) {
  const std::size_t l = in.l;
  const Friction on_motor = rub(
      in.motor_velocity, coupled(p.motor_velocity, p.free_motor_velocity, engaged, in, 0.0, load),
      p.free_motor_velocity.motor_load[l] * p.friction[l]);
  const Friction on_load =
      rub(in.load_velocity, coupled(p.load_velocity, p.free_load_velocity, engaged, in, 0.0, load),
          p.free_load_velocity.load_load[l] * p.load_friction[l]);
  const double dm = -on_motor.direction * p.friction[l];
  const double dl = load - on_load.direction * p.load_friction[l];
  const double vm = coupled(p.motor_velocity, p.free_motor_velocity, engaged, in, dm, dl);
  const double xm = coupled(p.motor_position, p.free_motor_position, engaged, in, dm, dl);
  const double vl = coupled(p.load_velocity, p.free_load_velocity, engaged, in, dm, dl);
  const double xl = coupled(p.load_position, p.free_load_position, engaged, in, dm, dl);
  return {on_motor.stuck ? 0.0 : vm, on_motor.stuck ? half_substep * in.motor_velocity : xm,
          on_load.stuck ? 0.0 : vl, on_load.stuck ? half_substep * in.load_velocity : xl};
}

template <bool kGeneral>
[[gnu::always_inline]] inline void step_elastic_lane(const ElasticParameters& p, ServoState& state,
                                                     std::size_t l, const MotionSample& demand,
                                                     double rate, double half_substep) {
  const double xm = state.position[l];
  const double xl = state.load_position[l];
  const double measured = quantise(xm, p.loop.counts_per_unit[l], p.loop.units_per_count[l]);
  const double load_measured =
      quantise(p.loop.closes_on_load[l] != 0.0 ? xl : xm, p.loop.load_counts_per_unit[l],
               p.loop.load_units_per_count[l]);
  const double u = control<kGeneral>(p.loop, state, l, demand, measured, load_measured, rate);
  const double torque = state.torque[l] * state.powered[l];

  // Inside the play both inertias are on their own; outside it the shaft is twisted by the rest.
  const double twist = p.loop.ratio[l] * xm + state.load_offset[l] - xl;
  const double play = p.half_backlash[l];
  const double below = twist > play ? play : twist;
  const double strain = twist - (below < -play ? -play : below);
  const bool engaged = (strain != 0.0) | (play == 0.0);

  const ElasticInput in{l, strain, state.velocity[l], state.load_velocity[l], torque, u};
  const ElasticStep next = advance(p, in, engaged, state.load_torque[l], half_substep);
  const bool blocked = state.blocked[l] != 0.0;
  state.position[l] = xm + next.motor_step;
  state.velocity[l] = next.motor_velocity;
  state.load_position[l] = blocked ? xl : xl + next.load_step;
  state.load_velocity[l] = blocked ? 0.0 : next.load_velocity;
  state.torque[l] = p.torque_from_torque[l] * torque + p.torque_from_command[l] * u;
}

template <bool kGeneral>
[[gnu::always_inline]] inline void step_rigid_lane(const RigidParameters& p, ServoState& state,
                                                   std::size_t l, const MotionSample& demand,
                                                   double rate, double half_substep) {
  const double x = state.position[l];
  const double v = state.velocity[l];
  const double measured = quantise(x, p.loop.counts_per_unit[l], p.loop.units_per_count[l]);
  const double load_x = p.loop.ratio[l] * x + state.load_offset[l];
  const double load_measured =
      quantise(p.loop.closes_on_load[l] != 0.0 ? load_x : x, p.loop.load_counts_per_unit[l],
               p.loop.load_units_per_count[l]);
  const double u = control<kGeneral>(p.loop, state, l, demand, measured, load_measured, rate);
  const double torque = state.torque[l] * state.powered[l];
  const double load = state.load_torque[l];
  const double free_velocity = p.velocity_from_velocity[l] * v +
                               p.velocity_from_torque[l] * torque + p.velocity_from_command[l] * u +
                               p.velocity_from_load[l] * load;
  const Friction friction = rub(v, free_velocity, p.velocity_from_load[l] * p.friction[l]);
  const double moved = x + p.position_from_velocity[l] * v + p.position_from_torque[l] * torque +
                       p.position_from_command[l] * u +
                       p.position_from_load[l] * (load - friction.direction * p.friction[l]);
  const double next = friction.stuck ? x + half_substep * v : moved;
  const bool blocked = state.blocked[l] != 0.0;
  state.position[l] = blocked ? x : next;
  state.velocity[l] = blocked ? 0.0 : friction.velocity;
  state.torque[l] = p.torque_from_torque[l] * torque + p.torque_from_command[l] * u;
}

[[gnu::always_inline]] inline MotionSample demand_at(const DemandBlock& demand, std::size_t k,
                                                     std::size_t l) {
  return {demand.positions[k][l], demand.velocities[k][l], demand.accelerations[k][l]};
}

template <bool kGeneral>
[[gnu::always_inline]] inline void step_rigid_block(const RigidParameters& parameters,
                                                    const DemandBlock& demand, ServoState& state,
                                                    std::size_t substeps, double substep) {
  const double rate = 1.0 / substep;
  const double half_substep = 0.5 * substep;
  for (std::size_t k = 0; k < substeps; ++k) {
    VDRIVE_INDEPENDENT_LANES
    for (std::size_t l = 0; l < kLanes; ++l) {
      step_rigid_lane<kGeneral>(parameters, state, l, demand_at(demand, k, l), rate, half_substep);
    }
  }
  const double tick_rate = 1.0 / (static_cast<double>(substeps) * substep);
  for (std::size_t l = 0; l < kLanes; ++l) {
    state.load_position[l] = parameters.loop.ratio[l] * state.position[l] + state.load_offset[l];
    read_encoders(parameters.loop, state, l, tick_rate);
  }
}

template <bool kGeneral>
[[gnu::always_inline]] inline void step_elastic_block(const ElasticParameters& parameters,
                                                      const DemandBlock& demand, ServoState& state,
                                                      std::size_t substeps, double substep) {
  const double rate = 1.0 / substep;
  const double half_substep = 0.5 * substep;
  for (std::size_t k = 0; k < substeps; ++k) {
    VDRIVE_INDEPENDENT_LANES
    for (std::size_t l = 0; l < kLanes; ++l) {
      step_elastic_lane<kGeneral>(parameters, state, l, demand_at(demand, k, l), rate,
                                  half_substep);
    }
  }
  const double tick_rate = 1.0 / (static_cast<double>(substeps) * substep);
  for (std::size_t l = 0; l < kLanes; ++l) read_encoders(parameters.loop, state, l, tick_rate);
}

}  // namespace

VDRIVE_VECTOR_CLONES
void step_rigid(const RigidParameters& parameters, const DemandBlock& demand, ServoState& state,
                std::size_t substeps, double substep) noexcept {
  step_rigid_block<false>(parameters, demand, state, substeps, substep);
}

VDRIVE_VECTOR_CLONES
void step_elastic(const ElasticParameters& parameters, const DemandBlock& demand, ServoState& state,
                  std::size_t substeps, double substep) noexcept {
  step_elastic_block<false>(parameters, demand, state, substeps, substep);
}

VDRIVE_VECTOR_CLONES
void step_rigid_general(const RigidParameters& parameters, const DemandBlock& demand,
                        ServoState& state, std::size_t substeps, double substep) noexcept {
  step_rigid_block<true>(parameters, demand, state, substeps, substep);
}

VDRIVE_VECTOR_CLONES
void step_elastic_general(const ElasticParameters& parameters, const DemandBlock& demand,
                          ServoState& state, std::size_t substeps, double substep) noexcept {
  step_elastic_block<true>(parameters, demand, state, substeps, substep);
}

}  // namespace vdrive
