// SPDX-License-Identifier: Apache-2.0
#include "drive/block.hpp"

#include "drive/frame.hpp"
#include "rounding.hpp"

#include <cmath>

namespace vdrive {
namespace {

/// The bit of each lane in a set of lanes.
constexpr std::array<std::uint64_t, kLanes> kBits{1, 2, 4, 8, 16, 32, 64, 128};

/// @return whether the axis in lane `l` is inside its target window.
[[gnu::always_inline]] inline bool is_near(const SteadyBlock& steady, std::size_t l, double load) {
  return std::abs(load - steady.target[l]) <= steady.target_window[l];
}

[[gnu::always_inline]] inline bool follows(const SteadyBlock& steady, std::size_t l, double demand,
                                           double load) {
  return std::abs(demand - load) <= steady.following_error_window[l];
}

/// Ends the steady tick of these lanes; see end_steady_tick.
template <bool kJerk>
[[gnu::always_inline]] inline std::uint64_t end_ticks(BlockState& block, std::uint64_t lanes,
                                                      const TickTiming& timing) {
  const double substeps = timing.substeps;
  const double substep = timing.substep;
  DemandBlock& demand = block.demand;
  std::uint64_t steady = 0;
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double ticks = demand.plan_ticks[l] + 1.0;
    const double time = (ticks * substeps) * substep;
    const MotionSample now = sample_lane<kJerk>(demand, l, time);
    const double load = nearest(block.servo.load_reading[l]);
    const bool is_steady = (lanes & kBits[l]) != 0U;
    const bool stands = (block.steady.standing & kBits[l]) != 0U;
    const bool in_segment = time < demand.end_time[l];
    const bool in_window = follows(block.steady, l, nearest(now.position), load);
    const bool as_before = is_near(block.steady, l, load) == stands;
    const bool moves_on = is_steady & in_segment & in_window & as_before;
    demand.plan_ticks[l] = moves_on ? ticks : demand.plan_ticks[l];
    demand.position[l] = moves_on ? now.position : demand.position[l];
    demand.velocity[l] = moves_on ? now.velocity : demand.velocity[l];
    steady |= moves_on ? kBits[l] : 0U;
  }
  return steady;
}

VDRIVE_VECTOR_CLONES
std::uint64_t end_plain_ticks(BlockState& block, std::uint64_t lanes, const TickTiming& timing) {
  return end_ticks<false>(block, lanes, timing);
}

VDRIVE_VECTOR_CLONES
std::uint64_t end_jerk_ticks(BlockState& block, std::uint64_t lanes, const TickTiming& timing) {
  return end_ticks<true>(block, lanes, timing);
}

}  // namespace

VDRIVE_VECTOR_CLONES
std::uint64_t lanes_out_of_frame(const DemandBlock& demand) noexcept {
  std::uint64_t lanes = 0;
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    lanes |= std::abs(demand.position[l]) > kFrame ? kBits[l] : 0U;
  }
  return lanes;
}

VDRIVE_VECTOR_CLONES
std::uint64_t lanes_across(const DemandBlock& demand, const TickTiming& timing) noexcept {
  const double substeps = timing.substeps;
  const double substep = timing.substep;
  std::uint64_t lanes = 0;
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double last = (demand.plan_ticks[l] * substeps + (substeps - 1.0)) * substep;
    lanes |= last >= demand.end_time[l] ? kBits[l] : 0U;
  }
  return lanes;
}

std::uint64_t end_steady_tick(BlockState& block, std::uint64_t lanes,
                              const TickTiming& timing) noexcept {
  return block.jerk_limited != 0 ? end_jerk_ticks(block, lanes, timing)
                                 : end_plain_ticks(block, lanes, timing);
}

VDRIVE_VECTOR_CLONES
void rest_at_load(DemandBlock& demand, const ServoState& servo, std::uint64_t lanes) noexcept {
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    const bool rests = (lanes & kBits[l]) != 0U;
    const double position = rests ? servo.load_reading[l] : demand.position[l];
    demand.segment_position[l] = rests ? position : demand.segment_position[l];
    demand.position[l] = position;
  }
}

VDRIVE_VECTOR_CLONES
void round_numbers(const BlockState& block, NumberBlock& numbers) noexcept {
  const ServoState& servo = block.servo;
  const UnitBlock& units = block.units;
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double demand = nearest(block.demand.position[l]);
    const double load = nearest(servo.load_reading[l]);
    const double motor = nearest(servo.motor_reading[l]);
    numbers.position_demand_value[l] = wrapped(demand);
    numbers.load_position_actual_value[l] = wrapped(load);
    numbers.load_position_error_value[l] = wrapped(demand - load);
    numbers.motor_position_actual_value[l] = wrapped(motor);
    numbers.motor_position_error_value[l] = wrapped(demand - motor);
  }
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double demand = nearest(block.demand.velocity[l]);
    const double load = nearest(servo.load_speed[l]);
    const double motor = nearest(servo.motor_speed[l]);
    numbers.velocity_demand_value[l] = saturated(demand);
    numbers.load_velocity_actual_value[l] = saturated(load);
    numbers.load_velocity_error_value[l] = saturated(demand - load);
    numbers.motor_velocity_actual_value[l] = saturated(motor);
    numbers.motor_velocity_error_value[l] = saturated(demand - motor);
  }
  VDRIVE_INDEPENDENT_LANES
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double torque_demand = rounded16(servo.command[l] * units.torque_per_mille[l]);
    const double current = rounded16(servo.torque[l] * units.current_per_mille[l]);
    numbers.torque_demand[l] = wrapped(torque_demand);
    numbers.torque_actual_value[l] =
        wrapped(rounded16(servo.torque[l] * units.torque_per_mille[l]));
    numbers.current_actual_value[l] = wrapped(current);
    numbers.current_error_value[l] =
        saturated((torque_demand - current) * units.rated_current[l] / 1000.0);
  }
}

}  // namespace vdrive
