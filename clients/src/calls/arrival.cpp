// SPDX-License-Identifier: Apache-2.0
#include "calls/arrival.hpp"

#include "base/drive_words.hpp"
#include "vdrive/dictionary/object_text.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace literals;

/// Objects that explain why an axis is at rest away from its target: software limits, then the
/// range.
constexpr std::array kArrivalObjects{kObjectRows["user_position_lower_limit"_object].address,
                                     kObjectRows["user_position_upper_limit"_object].address,
                                     kObjectRows["min_position_range_limit"_object].address,
                                     kObjectRows["max_position_range_limit"_object].address};
constexpr std::size_t kSoftwareLimits = 2;

constexpr std::uint8_t kNegativeLimitSwitch = 1U << 0U;  // of 60FDh
constexpr std::uint8_t kPositiveLimitSwitch = 1U << 1U;

/// @param target none if it is unknown; then the result has only the direction of motion
std::int64_t way_to(const AxisSnapshot& axis, std::optional<std::int32_t> target) {
  if (!target) return axis.status.velocity_demand_value;
  return std::int64_t{*target} - axis.status.position_demand_value;
}

bool is_on_its_way(const AxisSnapshot& axis) {
  return is_enabled(axis) && axis.status.velocity_demand_value != 0;
}

/// @return timed_out, with the position of the axis and the time it still needs at this speed.
Outcome still_moving(const AxesCall& call, std::int32_t target) {
  const AxisSnapshot& axis = call.snapshot();
  std::string message = "axis " + to_string(axis.id) + ": timed out while waiting for " +
                        std::string(kTargetReached) + ", at " +
                        call.position_text(axis.status.position_demand_value) + " of " +
                        call.position_text(target) + ", still moving at " +
                        call.velocity_text(axis.status.velocity_demand_value);
  if (const auto seconds = seconds_to(axis, target)) {
    message += ", about " + std::to_string(*seconds) + " s left at this speed";
  }
  return Outcome::timed_out(std::move(message));
}

std::string move_to(std::int32_t target, const Unit& unit) {
  return "the move to " + quantity_text(target, Dimension::position, unit);
}

}  // namespace

void LimitSwitchWatch::note(const AxisSnapshot& axis, std::int64_t way) {
  if (way == 0) return;
  const std::uint8_t in_the_way = way > 0 ? kPositiveLimitSwitch : kNegativeLimitSwitch;
  if ((axis.status.digital_inputs & in_the_way) == 0) return;
  input_ = way > 0 ? "positive limit switch (60FDh bit 1)" : "negative limit switch (60FDh bit 0)";
}

bool LimitSwitchWatch::has_ended(const AxisSnapshot& axis) const {
  return !input_.empty() && axis.status.velocity_demand_value == 0;
}

Outcome LimitSwitchWatch::outcome(const AxisSnapshot& axis, const Unit& unit,
                                  const std::string& what) const {
  if (input_.empty()) return {};
  return Outcome::failed(
      "axis " + to_string(axis.id) + ": the " + std::string(input_) + " ended " + what +
      " at position " +
      quantity_text(axis.status.load_position_actual_value, Dimension::position, unit));
}

Outcome outcome_of_halt(const AxisSnapshot& axis, std::uint16_t word) {
  if ((word & Controlword::kHalt) == 0) return {};
  return Outcome::failed("axis " + to_string(axis.id) + " was halted before it reached its target");
}

Outcome continues_to_target(const AxisSnapshot& axis) {
  return Outcome::failed("interrupted; axis " + to_string(axis.id) +
                         " was not stopped: it continues to its target while its bench runs");
}

Outcome check_halt(AxesCall& call) {
  const auto present = call.read(kControlwordObject);
  if (!present) return present.outcome();
  return outcome_of_halt(call.snapshot(), static_cast<std::uint16_t>(present->front().front()));
}

Outcome check_limit_switch(const AxesCall& call, const AxisSnapshot& axis, std::int32_t target) {
  LimitSwitchWatch limit_switch;
  limit_switch.note(axis, way_to(axis, target));
  if (!limit_switch.has_ended(axis)) return {};
  const Unit unit = call.unit_of(axis.id);
  return limit_switch.outcome(axis, unit, move_to(target, unit));
}

Outcome check_arrival(AxesCall& call, const AxisSnapshot& at_rest, std::int32_t target,
                      bool is_exact) {
  const std::int32_t demand = at_rest.status.position_demand_value;
  if (demand == target) return {};
  const auto values = call.read(kArrivalObjects);
  if (!values) return values.outcome();
  const std::vector<std::int64_t>& read = values->front();
  const auto limits = std::span(read).first(kSoftwareLimits);
  const auto limit = std::ranges::find(limits, demand);
  const std::string axis = "axis " + to_string(at_rest.id) + ": ";
  const std::string place_of_rest = call.position_text(demand);
  const std::string move = move_to(target, call.unit_of(at_rest.id));
  if (at_rest.shows(Statusword::kInternalLimitActive) && limit != limits.end()) {
    const auto place = static_cast<std::size_t>(limit - limits.begin());
    return Outcome::failed(axis + "the software limit " + object_text(kArrivalObjects.at(place)) +
                           " = " + place_of_rest + " cut short " + move);
  }
  const std::int64_t span = read.back() - read[kSoftwareLimits];
  const bool is_there = span > 0 && (std::int64_t{target} - demand) % span == 0;
  if (is_there || !is_exact) return {};
  return Outcome::failed(axis + "stopped at " + place_of_rest + " (6062h): " + move +
                         " was ended by something else");
}

Outcome check_set_point(const AxisSnapshot& axis) {
  if (axis.mode() != OperatingMode::profile_position) {
    return Outcome::failed("axis " + to_string(axis.id) + ": superseded by " +
                           std::string(to_string(axis.mode())) +
                           " mode (6061h = " + std::to_string(axis.status.op_mode_actual) +
                           "); waited for " + std::string(kTargetReached));
  }
  if (axis.last_sequence != 0 || !axis.has_owner) return {};
  return Outcome::failed(
      "axis " + to_string(axis.id) +
      ": control of it was released or taken over after the set-point; waited for " +
      std::string(kTargetReached));
}

Outcome await_target(AxesCall& call, const Wakeup& wakeup, std::optional<std::int32_t> target,
                     std::uint64_t from) {
  LimitSwitchWatch limit_switch;
  Outcome reached = call.await_enabled(kTargetReached, from, [&](const AxisSnapshot& axis) {
    limit_switch.note(axis, way_to(axis, target));
    return target_reached(axis) || limit_switch.has_ended(axis) || !check_set_point(axis);
  });
  if (reached) reached = check_set_point(call.snapshot());
  if (reached && !target_reached(call.snapshot())) {
    const Unit unit = call.unit_of(call.snapshot().id);
    return limit_switch.outcome(call.snapshot(), unit,
                                target ? move_to(*target, unit) : "the motion");
  }
  if (reached.kind() == OutcomeKind::timed_out && target && is_on_its_way(call.snapshot())) {
    return still_moving(call, *target);
  }
  if (reached.kind() == OutcomeKind::failed && is_enabled(call.snapshot()) &&
      wakeup.is_interrupted()) {
    return continues_to_target(call.snapshot());
  }
  return reached ? check_halt(call) : reached;
}

}  // namespace vdrive::client
