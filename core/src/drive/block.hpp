// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/axis_status.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdrive {

// Operations of a tick on all lanes of a block at the same time. A set of lanes is a bit mask: bit
// l stands for lane l.

/// @return the lanes whose position is further from 0 than `kFrame`.
[[nodiscard]] std::uint64_t lanes_out_of_frame(const DemandBlock& demand) noexcept;

/// @return the lanes in which the present tick crosses a border between two segments.
[[nodiscard]] std::uint64_t lanes_across(const DemandBlock& demand,
                                         const TickTiming& timing) noexcept;

/// Ends the tick of those `lanes` that are still steady (drive/tick.hpp): the demand stays within
/// its segment and the following error within its window; the axis stays outside the target window
/// or, if it stands on its target, inside it.
/// @return these lanes; the other lanes are unchanged.
std::uint64_t end_steady_tick(BlockState& block, std::uint64_t lanes,
                              const TickTiming& timing) noexcept;

/// Ends the tick of `lanes` without power: their demand follows the position of the load.
void rest_at_load(DemandBlock& demand, const ServoState& servo, std::uint64_t lanes) noexcept;

/// The measured or planned members of AxisStatus, for a block.
struct alignas(64) NumberBlock {
  using Row = std::array<std::int32_t, kLanes>;

  Row position_demand_value;
  Row load_position_actual_value;
  Row load_position_error_value;
  Row motor_position_actual_value;
  Row motor_position_error_value;
  Row velocity_demand_value;
  Row load_velocity_actual_value;
  Row load_velocity_error_value;
  Row motor_velocity_actual_value;
  Row motor_velocity_error_value;
  Row current_error_value;
  Row current_actual_value;
  Row torque_actual_value;
  Row torque_demand;
};

void round_numbers(const BlockState& block, NumberBlock& numbers) noexcept;

/// Copies the numbers of lane `l` into the status image.
inline void show_numbers(const NumberBlock& numbers, std::size_t l, AxisStatus& out) noexcept {
  out.position_demand_value = numbers.position_demand_value[l];
  out.load_position_actual_value = numbers.load_position_actual_value[l];
  out.load_position_error_value = numbers.load_position_error_value[l];
  out.motor_position_actual_value = numbers.motor_position_actual_value[l];
  out.motor_position_error_value = numbers.motor_position_error_value[l];
  out.velocity_demand_value = numbers.velocity_demand_value[l];
  out.load_velocity_actual_value = numbers.load_velocity_actual_value[l];
  out.load_velocity_error_value = numbers.load_velocity_error_value[l];
  out.motor_velocity_actual_value = numbers.motor_velocity_actual_value[l];
  out.motor_velocity_error_value = numbers.motor_velocity_error_value[l];
  out.current_error_value = numbers.current_error_value[l];
  out.current_actual_value = static_cast<std::int16_t>(numbers.current_actual_value[l]);
  out.torque_actual_value = static_cast<std::int16_t>(numbers.torque_actual_value[l]);
  out.torque_demand = static_cast<std::int16_t>(numbers.torque_demand[l]);
}

}  // namespace vdrive
