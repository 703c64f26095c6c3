// SPDX-License-Identifier: Apache-2.0
#include "execution/fault_watch.hpp"

#include "output/event_view.hpp"
#include "output/report.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

namespace vdrive::tool {
namespace {

// Longer than a reset takes, and than any motor needs to be seen moving.
constexpr std::chrono::milliseconds kStandstill{100};

// A drive without power coasts: from here on its speed is what the encoder makes of standing still.
constexpr std::int32_t kRest = 20;  // [UU/s]

bool is_at_rest(const client::AxisSnapshot& axis) {
  return std::abs(axis.status.load_velocity_actual_value) <= kRest;
}

}  // namespace

FaultWatch::FaultWatch(std::chrono::microseconds period)
    : patience_(client::ticks_of(kStandstill, period)) {}

void FaultWatch::note(const client::AxisSnapshot& axis) {
  if (!is_fault(axis.state())) {
    was_sound_ = true;
    fault_tick_ = 0;
  } else if (fault_tick_ == 0) {
    fault_tick_ = axis.tick;
  }
  const bool stays = axis.state() == PowerState::fault && is_at_rest(axis);
  if (!stays) since_.reset();
  if (stays && !since_) since_ = axis.driven_tick();
  is_over_ = since_ && axis.driven_tick() - *since_ >= patience_;
}

std::string fault_text(client::Session& session, const client::AxisSnapshot& axis,
                       const FaultWatch& watch) {
  const auto tick = watch.saw_begin()
                        ? std::optional(watch.first_tick())
                        : tick_of_fault(kept_events(session), axis.id, axis.status.error_code);
  return "axis " + to_string(axis.id) + " is in " + state_text(axis) + ", since tick " +
         (tick ? std::to_string(*tick) : std::to_string(watch.first_tick()) + " or before");
}

bool is_out_of_reach_in_fault(std::string_view condition) noexcept {
  constexpr std::array<std::string_view, 5> kComeInFault{
      "switch_on_disabled", "voltage_enabled", "internal_limit_active", "warning", "remote"};
  return std::ranges::find(kComeInFault, condition) == kComeInFault.end();
}

bool is_out_of_reach_in_fault(const Expectation& expectation) {
  using namespace literals;
  const auto row = expectation.object.row();
  if (!row) return false;
  constexpr std::array kOfMotion{"torque_demand"_object, "torque_actual_value"_object,
                                 "current_actual_value"_object, "op_mode_actual"_object};
  const bool is_of_motion =
      dimension_of(*row) || std::ranges::find(kOfMotion, *row) != kOfMotion.end();
  if (is_of_motion) return describe(*row).access == Access::read_only;  // what the axis shows
  if (*row != "ds402_statusword"_object || expectation.comparison != Comparison::equal)
    return false;
  constexpr std::uint64_t kSwitchOnDisabled = 1U << 6U;
  const std::uint64_t mask = expectation.mask.value_or(~std::uint64_t{0});
  const auto value = static_cast<std::uint64_t>(expectation.value);
  // Bit 12 is the mode's, and the mode sets it in Operation enabled only.
  constexpr std::uint64_t kNeverInFault =
      Statusword::kOperationEnabled | Statusword::kTargetReached | Statusword::kSetPointAcknowledge;
  const bool needs_no_fault = (mask & Statusword::kFault) != 0 && (value & Statusword::kFault) == 0;
  const bool needs_power = (value & mask & kNeverInFault) != 0;
  return (needs_no_fault || needs_power) && (value & mask & kSwitchOnDisabled) == 0;
}

}  // namespace vdrive::tool
