// SPDX-License-Identifier: Apache-2.0
#include "engine/bench_brake.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <cstdlib>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

constexpr ObjectRow kControlword = "ds402_controlword"_object;

bool can_be_stopped(PowerState state) {
  return state == PowerState::operation_enabled || state == PowerState::quick_stop_active;
}

bool is_powered_not_enabled(PowerState state) {
  return state == PowerState::ready_to_switch_on || state == PowerState::switched_on;
}

}  // namespace

BenchBrake::BenchBrake(BenchAxes& axes, FrameSchedule& schedule, BenchEvents& events)
    : axes_(axes), schedule_(schedule), events_(events) {}

void BenchBrake::engage(Braking braking) {
  if (!braking_) {
    schedule_.cancel_all();
    events_.report({.kind = msg::EventKind::shutdown});
  }
  braking_ = braking;
  for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
    stop_axis(axis, braking);
    switch_off_at_rest(axis);
  }
}

void BenchBrake::switch_off_at_rest() {
  for (std::size_t axis = 0; is_engaged() && axis < axes_.size(); ++axis) switch_off_at_rest(axis);
}

bool BenchBrake::has_power() const noexcept {
  for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
    const PowerState state = axes_.bank().power_state(axis);
    if (can_be_stopped(state) || is_powered_not_enabled(state) ||
        state == PowerState::fault_reaction_active) {
      return true;
    }
  }
  return false;
}

void BenchBrake::stop_axis(std::size_t axis, Braking braking) {
  const PowerState state = axes_.bank().power_state(axis);
  const bool is_enabled = state == PowerState::operation_enabled;
  switch (braking) {
    case Braking::ramp:
      if (is_enabled) axes_.write(axis, kControlword, controlwords::kDisableOperation);
      break;
    case Braking::quick_stop:
      if (is_enabled) axes_.write(axis, kControlword, controlwords::kQuickStop);
      break;
    case Braking::none:
      if (can_be_stopped(state)) axes_.write(axis, kControlword, controlwords::kDisableVoltage);
      break;
  }
}

/// Switches off an axis that is in Switched on or Ready to switch on, or is at standstill in Quick
/// stop active.
void BenchBrake::switch_off_at_rest(std::size_t axis) {
  const PowerState state = axes_.bank().power_state(axis);
  if (is_powered_not_enabled(state) ||
      (state == PowerState::quick_stop_active && is_at_standstill(axis))) {
    axes_.write(axis, kControlword, controlwords::kDisableVoltage);
  }
}

bool BenchBrake::is_at_standstill(std::size_t axis) const noexcept {
  const AxisStatus& status = axes_.bank().status(axis);
  const std::int64_t threshold = axes_.bank().read(axis, "velocity_threshold"_object).value;
  return status.velocity_demand_value == 0 &&
         std::abs(std::int64_t{status.load_velocity_actual_value}) <= threshold;
}

}  // namespace vdrive::service
