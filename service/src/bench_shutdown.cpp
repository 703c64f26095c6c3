// SPDX-License-Identifier: Apache-2.0
// The end of a bench: no more commands, axes come to rest and lose their power.
#include "bench_engine.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <cstdlib>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

constexpr ObjectAddress kControlword{0x6040, 0};

// The commands of CiA 402, by the bits of 6040h.
constexpr std::uint16_t kQuickStopCommand = Controlword::kEnableVoltage;
constexpr std::uint16_t kDisableOperation =
    Controlword::kSwitchOn | Controlword::kEnableVoltage | Controlword::kQuickStop;
constexpr std::uint16_t kDisableVoltage = 0;

bool can_be_stopped(PowerState state) {
  return state == PowerState::operation_enabled || state == PowerState::quick_stop_active;
}

bool is_between(PowerState state) {
  return state == PowerState::ready_to_switch_on || state == PowerState::switched_on;
}

}  // namespace

void BenchEngine::shut_down(Braking braking) {
  if (!braking_) {
    pending_.drop_if(
        [](const auto& /*frame*/) {
          return true;
        },
        [&](const auto& frame) {
          refuse_frame(frame, msg::REASON_CANCELLED);
        });
    report({.kind = msg::EVENT_SHUTDOWN});
  }
  braking_ = braking;
  for (std::size_t axis = 0; axis < numbers_.size(); ++axis) {
    stop_axis(axis);
    switch_off_at_rest(axis);
  }
}

bool BenchEngine::has_power() const noexcept {
  for (std::size_t axis = 0; axis < numbers_.size(); ++axis) {
    const PowerState state = bank_.power_state(axis);
    if (can_be_stopped(state) || is_between(state) || state == PowerState::fault_reaction_active) {
      return true;
    }
  }
  return false;
}

void BenchEngine::stop_axis(std::size_t axis) {
  const PowerState state = bank_.power_state(axis);
  switch (*braking_) {
    case Braking::ramp:
      if (state == PowerState::operation_enabled) write(axis, kControlword, kDisableOperation);
      break;
    case Braking::quick_stop:
      if (state == PowerState::operation_enabled) write(axis, kControlword, kQuickStopCommand);
      break;
    case Braking::none:
      if (can_be_stopped(state)) write(axis, kControlword, kDisableVoltage);
      break;
  }
}

/// What has come to rest in Switched on, or holds its position after a quick stop.
void BenchEngine::switch_off_at_rest(std::size_t axis) {
  const PowerState state = bank_.power_state(axis);
  if (is_between(state) || (state == PowerState::quick_stop_active && stands(axis))) {
    write(axis, kControlword, kDisableVoltage);
  }
}

bool BenchEngine::stands(std::size_t axis) const noexcept {
  const AxisStatus& status = bank_.status(axis);
  const std::int64_t threshold =
      bank_.read(axis, describe("velocity_threshold"_object).address).value;
  return status.velocity_demand_value == 0 &&
         std::abs(std::int64_t{status.load_velocity_actual_value}) <= threshold;
}

}  // namespace vdrive::service
