// SPDX-License-Identifier: Apache-2.0
#include "execution/fault_watch.hpp"

#include "output/report.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/dictionary/dictionary.hpp"

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

client::Outcome FaultWatch::note(const client::AxisSnapshot& axis, std::string_view awaited) {
  if (axis.state() != PowerState::fault) {
    was_sound_ = true;
    fault_tick_ = 0;
    since_.reset();
    return {};
  }
  if (fault_tick_ == 0) fault_tick_ = axis.tick;
  if (!is_at_rest(axis)) since_.reset();
  if (!since_ && is_at_rest(axis)) since_ = axis.driven_tick();
  if (!since_ || axis.driven_tick() - *since_ < patience_) return {};
  return client::Outcome::failed("axis " + to_string(axis.id) + " is in " + state_text(axis) +
                                 ", since tick " + std::to_string(fault_tick_) +
                                 (was_sound_ ? "" : " or before") + "; waited for " +
                                 std::string(awaited));
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
  constexpr std::array kOfMotors{"torque_demand"_object, "torque_actual_value"_object,
                                 "current_actual_value"_object};
  const bool is_of_motion =
      dimension_of(*row) || std::ranges::find(kOfMotors, *row) != kOfMotors.end();
  if (is_of_motion) return describe(*row).access == Access::read_only;  // what the axis shows
  if (*row != "ds402_statusword"_object || expectation.comparison != Comparison::equal)
    return false;
  constexpr std::uint64_t kSwitchOnDisabled = 1U << 6U;
  const std::uint64_t mask = expectation.mask.value_or(~std::uint64_t{0});
  const auto value = static_cast<std::uint64_t>(expectation.value);
  constexpr std::uint64_t kNeverInFault =
      Statusword::kOperationEnabled | Statusword::kTargetReached;
  const bool needs_no_fault = (mask & Statusword::kFault) != 0 && (value & Statusword::kFault) == 0;
  const bool needs_power = (value & mask & kNeverInFault) != 0;
  return (needs_no_fault || needs_power) && (value & mask & kSwitchOnDisabled) == 0;
}

}  // namespace vdrive::tool
