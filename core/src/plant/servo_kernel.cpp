// SPDX-License-Identifier: Apache-2.0
//
// The hot loops: plain loops over lanes that the compiler vectorises for each instruction set. Only
// + - * / and comparisons, no contraction, no sum across lanes: the same bits for every width.
#include "plant/servo_block.hpp"

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

/// Position P, velocity PI with feed-forward, clamped without wind-up: the torque command.
[[gnu::always_inline]] inline double control(const LoopParameters& p, ServoState& s, std::size_t l,
                                             double demand_position, double demand_velocity,
                                             double demand_acceleration, double measured,
                                             double load_measured, double rate) {
  const double measured_velocity = (measured - s.measured[l]) * rate;
  const double wanted = (p.position_gain[l] * (demand_position - load_measured) + demand_velocity) *
                        p.inverse_ratio[l];
  const double error = wanted - measured_velocity;
  const double free_command =
      p.velocity_gain[l] * error + s.integrator[l] + p.feed_forward[l] * demand_acceleration;
  const double below = free_command > p.upper_limit[l] ? p.upper_limit[l] : free_command;
  const double command = below < p.lower_limit[l] ? p.lower_limit[l] : below;
  const bool winds_up = (free_command - command) * error > 0.0;
  const double powered = s.powered[l];
  s.integrator[l] = (s.integrator[l] + (winds_up ? 0.0 : p.integral_step[l] * error)) * powered;
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
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double tau = (demand.first_substep[l] + step) * substep - demand.reference_time[l];
      demand.positions[k][l] =
          demand.position[l] + (demand.velocity[l] + 0.5 * demand.acceleration[l] * tau) * tau;
      demand.velocities[k][l] = demand.velocity[l] + demand.acceleration[l] * tau;
      demand.accelerations[k][l] = demand.acceleration[l];
    }
  }
}

VDRIVE_VECTOR_CLONES
void step_rigid(const RigidParameters& parameters, const DemandBlock& demand, ServoState& state,
                std::size_t substeps, double substep) noexcept {
  const RigidParameters& p = parameters;
  const double rate = 1.0 / substep;
  const double tick_rate = 1.0 / (static_cast<double>(substeps) * substep);
  const double half_substep = 0.5 * substep;
  for (std::size_t k = 0; k < substeps; ++k) {
    VDRIVE_INDEPENDENT_LANES
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double x = state.position[l];
      const double v = state.velocity[l];
      const double measured = quantise(x, p.loop.counts_per_unit[l], p.loop.units_per_count[l]);
      const double load_x = p.loop.ratio[l] * x + state.load_offset[l];
      const double load_measured =
          quantise(p.loop.closes_on_load[l] != 0.0 ? load_x : x, p.loop.load_counts_per_unit[l],
                   p.loop.load_units_per_count[l]);
      const double u = control(p.loop, state, l, demand.positions[k][l], demand.velocities[k][l],
                               demand.accelerations[k][l], measured, load_measured, rate);
      const double torque = state.torque[l] * state.powered[l];
      const double load = state.load_torque[l];
      const double free_velocity = p.velocity_from_velocity[l] * v +
                                   p.velocity_from_torque[l] * torque +
                                   p.velocity_from_command[l] * u + p.velocity_from_load[l] * load;
      const Friction friction = rub(v, free_velocity, p.velocity_from_load[l] * p.friction[l]);
      const double moved = x + p.position_from_velocity[l] * v +
                           p.position_from_torque[l] * torque + p.position_from_command[l] * u +
                           p.position_from_load[l] * (load - friction.direction * p.friction[l]);
      const double next = friction.stuck ? x + half_substep * v : moved;
      const bool blocked = state.blocked[l] != 0.0;
      state.position[l] = blocked ? x : next;
      state.velocity[l] = blocked ? 0.0 : friction.velocity;
      state.torque[l] = p.torque_from_torque[l] * torque + p.torque_from_command[l] * u;
    }
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    state.load_position[l] = p.loop.ratio[l] * state.position[l] + state.load_offset[l];
    read_encoders(p.loop, state, l, tick_rate);
  }
}

namespace {

[[gnu::always_inline]] inline double apply(const ElasticRow& row, std::size_t l, double twist,
                                           double motor_velocity, double load_velocity,
                                           double torque, double command, double motor_load,
                                           double load_load) {
  return row.twist[l] * twist + row.motor_velocity[l] * motor_velocity +
         row.load_velocity[l] * load_velocity + row.torque[l] * torque + row.command[l] * command +
         row.motor_load[l] * motor_load + row.load_load[l] * load_load;
}

}  // namespace

VDRIVE_VECTOR_CLONES
void step_elastic(const ElasticParameters& parameters, const DemandBlock& demand, ServoState& state,
                  std::size_t substeps, double substep) noexcept {
  const ElasticParameters& p = parameters;
  const double rate = 1.0 / substep;
  const double tick_rate = 1.0 / (static_cast<double>(substeps) * substep);
  const double half_substep = 0.5 * substep;
  for (std::size_t k = 0; k < substeps; ++k) {
    VDRIVE_INDEPENDENT_LANES
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double xm = state.position[l];
      const double vm = state.velocity[l];
      const double xl = state.load_position[l];
      const double vl = state.load_velocity[l];
      const double measured = quantise(xm, p.loop.counts_per_unit[l], p.loop.units_per_count[l]);
      const double load_measured =
          quantise(p.loop.closes_on_load[l] != 0.0 ? xl : xm, p.loop.load_counts_per_unit[l],
                   p.loop.load_units_per_count[l]);
      const double u = control(p.loop, state, l, demand.positions[k][l], demand.velocities[k][l],
                               demand.accelerations[k][l], measured, load_measured, rate);
      const double torque = state.torque[l] * state.powered[l];
      const double load = state.load_torque[l];

      // Inside the play both inertias are on their own; outside it the shaft is twisted by the
      // rest.
      const double twist = p.loop.ratio[l] * xm + state.load_offset[l] - xl;
      const double play = p.half_backlash[l];
      const double within = twist > play ? play : (twist < -play ? -play : twist);
      const double strain = twist - within;
      const bool engaged = (strain != 0.0) | (play == 0.0);

      const double vm_engaged = apply(p.motor_velocity, l, strain, vm, vl, torque, u, 0.0, load);
      const double vm_loose = apply(p.free_motor_velocity, l, 0.0, vm, vl, torque, u, 0.0, load);
      const double vl_engaged = apply(p.load_velocity, l, strain, vm, vl, torque, u, 0.0, load);
      const double vl_loose = apply(p.free_load_velocity, l, 0.0, vm, vl, torque, u, 0.0, load);
      const double vm_free = engaged ? vm_engaged : vm_loose;
      const double vl_free = engaged ? vl_engaged : vl_loose;
      const Friction on_motor =
          rub(vm, vm_free, p.free_motor_velocity.motor_load[l] * p.friction[l]);
      const Friction on_load =
          rub(vl, vl_free, p.free_load_velocity.load_load[l] * p.load_friction[l]);
      const double dm = -on_motor.direction * p.friction[l];
      const double dl = load - on_load.direction * p.load_friction[l];

      const double vm_next = engaged
                                 ? apply(p.motor_velocity, l, strain, vm, vl, torque, u, dm, dl)
                                 : apply(p.free_motor_velocity, l, 0.0, vm, vl, torque, u, dm, dl);
      const double vl_next = engaged
                                 ? apply(p.load_velocity, l, strain, vm, vl, torque, u, dm, dl)
                                 : apply(p.free_load_velocity, l, 0.0, vm, vl, torque, u, dm, dl);
      const double xm_moved = engaged
                                  ? apply(p.motor_position, l, strain, vm, vl, torque, u, dm, dl)
                                  : apply(p.free_motor_position, l, 0.0, vm, vl, torque, u, dm, dl);
      const double xl_moved = engaged
                                  ? apply(p.load_position, l, strain, vm, vl, torque, u, dm, dl)
                                  : apply(p.free_load_position, l, 0.0, vm, vl, torque, u, dm, dl);

      const bool blocked = state.blocked[l] != 0.0;
      state.position[l] = xm + (on_motor.stuck ? half_substep * vm : xm_moved);
      state.velocity[l] = on_motor.stuck ? 0.0 : vm_next;
      state.load_position[l] = blocked ? xl : xl + (on_load.stuck ? half_substep * vl : xl_moved);
      state.load_velocity[l] = (blocked | on_load.stuck) ? 0.0 : vl_next;
      state.torque[l] = p.torque_from_torque[l] * torque + p.torque_from_command[l] * u;
    }
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    read_encoders(p.loop, state, l, tick_rate);
  }
}

}  // namespace vdrive
