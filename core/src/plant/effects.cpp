// SPDX-License-Identifier: Apache-2.0
#include "plant/effects.hpp"

#include "scramble.hpp"

#include <algorithm>
#include <limits>
#include <type_traits>

namespace vdrive {
namespace {

static_assert(std::is_trivially_copyable_v<EffectBlock>);

constexpr double kInfiniteDistance = std::numeric_limits<double>::infinity();

/// Below this heat a cooling motor counts as cold. Otherwise the heat would approach 0 for hundreds
/// of time constants, and the block of the axis could not settle: every tick would still change it.
constexpr double kColdest = 1.0e-9;

/// @return `seconds` as a whole number of ticks, rounded up; the tolerance avoids an extra tick
///         from the rounding of the division.
double ticks_of(double seconds, double period) {
  constexpr double kRounding = 1.0e-9;
  return std::max(std::ceil(seconds / period - kRounding), 0.0);
}

/// The fraction 1 - exp(-x) of a step response after x time constants, as a quotient that gives the
/// same bits on every machine: accurate to x³/12, at most 1.
double settled_fraction(double time_constants) {
  return std::min(time_constants / (1.0 + 0.5 * time_constants), 1.0);
}

void set_lane(std::uint64_t& lanes, std::size_t lane, bool is_set) {
  const std::uint64_t of_lane = std::uint64_t{1} << lane;
  lanes = is_set ? lanes | of_lane : lanes & ~of_lane;
}

/// @return whether a power stage was switched since the last tick.
bool is_switched(const EffectState& state, const ServoState& servo) {
  std::uint64_t others = 0;
  for (std::size_t l = 0; l < kLanes; ++l) {
    others |= servo.powered[l] == state.powered[l] ? 0U : 1U;
  }
  return others != 0;
}

/// One tick of the brake in lane `l`.
/// @return whether it has followed the power stage.
bool move_brake(const EffectParameters& p, const ServoState& servo, std::size_t l, EffectState& s) {
  const bool powered = servo.powered[l] != 0.0;
  const double needed = powered ? p.release_ticks[l] : p.engage_ticks[l];
  const double ticks = servo.powered[l] == s.powered[l] ? s.brake_ticks[l] : 0.0;
  const bool has_followed = ticks >= needed;
  // Until it follows, the brake keeps its state, whatever the power stage has done since.
  const bool closed = has_followed ? !powered : s.brake[l] != 0.0;
  s.powered[l] = servo.powered[l];
  s.brake_ticks[l] = has_followed ? ticks : ticks + 1.0;
  s.brake[l] = closed ? p.brake[l] : 0.0;
  s.brake_impulse[l] = closed ? p.brake_impulse[l] : 0.0;
  return has_followed;
}

/// @return the position of an end stop; `infinite` if the parameter is `none`.
double end_stop(double parameter, double none, double infinite) {
  return parameter == none ? infinite : parameter;
}

}  // namespace

EffectBlock no_effects() noexcept {
  EffectBlock block{};
  block.parameters.lower_stop.fill(-kInfiniteDistance);
  block.parameters.upper_stop.fill(kInfiniteDistance);
  block.parameters.motor_per_load.fill(1.0);
  block.state.lower_stop.fill(-kInfiniteDistance);
  block.state.upper_stop.fill(kInfiniteDistance);
  return block;
}

void design_effects(const AxisModel& model, const Gear& gear, const EffectDesign& design,
                    std::size_t lane, EffectBlock& block) noexcept {
  EffectParameters& parameters = block.parameters;
  const double unit = torque_unit(model, gear);
  const bool dual = model.feedback == Feedback::dual_encoder;
  parameters.cogging[lane] = -model.cogging_torque / unit;
  parameters.cogging_turns[lane] = model.cogging_periods / kUserUnitsPerRevolution;
  parameters.ripple[lane] = model.torque_ripple * 0.01;
  parameters.ripple_turns[lane] = model.torque_ripple_periods / kUserUnitsPerRevolution;
  parameters.brake[lane] = model.brake_torque / unit;
  parameters.brake_impulse[lane] = parameters.brake[lane] * design.velocity_from_load;
  parameters.release_ticks[lane] = ticks_of(model.brake_release_time, design.period);
  parameters.engage_ticks[lane] = ticks_of(model.brake_engage_time, design.period);
  parameters.lower_stop[lane] = end_stop(model.lower_end_stop, kNoLowerEndStop, -kInfiniteDistance);
  parameters.upper_stop[lane] = end_stop(model.upper_end_stop, kNoUpperEndStop, kInfiniteDistance);
  parameters.motor_per_load[lane] = 1.0 / ratio_of(gear);
  parameters.motor_noise[lane] = model.encoder_noise;
  parameters.load_noise[lane] = dual ? model.load_encoder_noise : 0.0;
  parameters.shares_encoder[lane] = dual ? 0.0 : 1.0;
  parameters.heat_gain[lane] =
      model.motor_thermal_time_constant == 0.0
          ? 0.0
          : settled_fraction(design.period / model.motor_thermal_time_constant);
  set_lane(parameters.cogged, lane, parameters.cogging[lane] != 0.0);
  set_lane(parameters.rippled, lane, parameters.ripple[lane] != 0.0);
  set_lane(parameters.stopped, lane,
           parameters.lower_stop[lane] != -kInfiniteDistance ||
               parameters.upper_stop[lane] != kInfiniteDistance);
  set_lane(block.state.following, lane, true);
}

void start_effects(const AxisModel& model, std::uint64_t axis, std::size_t lane,
                   EffectBlock& block) noexcept {
  EffectState& state = block.state;
  // Inverted, so that the numbers differ from those of a load noise with the same seed.
  const std::uint64_t seed = ~scramble(static_cast<std::uint64_t>(model.encoder_noise_seed));
  state.streams[lane] = scramble(seed + axis);
  if (model.encoder_noise != 0.0 || model.load_encoder_noise != 0.0) {
    state.noisy |= std::uint64_t{1} << lane;
  }
  state.brake[lane] = block.parameters.brake[lane];
  state.brake_impulse[lane] = block.parameters.brake_impulse[lane];
  state.brake_ticks[lane] = block.parameters.engage_ticks[lane];
  place_effects(block, lane, {});
}

void place_effects(EffectBlock& block, std::size_t lane, const Origins& origins) noexcept {
  block.state.motor_origin[lane] = origins.motor;
  block.state.lower_stop[lane] = block.parameters.lower_stop[lane] + origins.load;
  block.state.upper_stop[lane] = block.parameters.upper_stop[lane] + origins.load;
}

void move_brakes(EffectBlock& block, const ServoState& servo) noexcept {
  EffectState& state = block.state;
  if (state.following == 0 && !is_switched(state, servo)) return;
  state.following = 0;
  for (std::size_t l = 0; l < kLanes; ++l) {
    if (!move_brake(block.parameters, servo, l, state)) state.following |= std::uint64_t{1} << l;
  }
}

void heat_motors(EffectBlock& block, const ServoState& servo,
                 const Lane& current_per_mille) noexcept {
  EffectState& s = block.state;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double current = servo.torque[l] * current_per_mille[l] * 1.0e-3;  // 1 = rated current
    const double before = s.heat[l];
    const double heat = before + block.parameters.heat_gain[l] * (current * current - before);
    s.heat[l] = heat < before && heat < kColdest ? 0.0 : heat;
  }
}

std::uint64_t lanes_hotter(const EffectState& state, double heat) noexcept {
  std::uint64_t lanes = 0;
  for (std::size_t l = 0; l < kLanes; ++l) {
    lanes |= state.heat[l] > heat ? std::uint64_t{1} << l : 0U;
  }
  return lanes;
}

}  // namespace vdrive
