// SPDX-License-Identifier: Apache-2.0
#include "judge/axis_track.hpp"

#include "judge/rule.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>
#include <utility>

namespace vdrive::judge {
namespace {

/// A node follows an NMT start within this time.
constexpr Time kStartTime = std::chrono::seconds(1);

/// Thresholds of is_moving() for the distance over the last positions and for the last step. Noise
/// at standstill stays below them in any unit, because it is small compared with the travel of the
/// axis.
constexpr std::int64_t kMovingWay = 10;      // [user units]
constexpr std::int64_t kMovingStep = 3;      // [user units]
constexpr std::int64_t kMovingShare = 1000;  // of the total travel of the axis

struct FactOfObject {
  ObjectAddress object;
  std::uint32_t fact = 0;
};

constexpr std::array kFactsOfValues{
    FactOfObject{objects::kLowerLimit, Fact::kPositionLimits},
    FactOfObject{objects::kUpperLimit, Fact::kPositionLimits},
    FactOfObject{objects::kSpeedLimit, Fact::kSpeedLimit},
    FactOfObject{objects::kFollowingWindow, Fact::kFollowingWindow},
    FactOfObject{objects::kMaxTorque, Fact::kTorqueLimit},
    FactOfObject{objects::kCyclePeriod, Fact::kCyclePeriod},
    FactOfObject{objects::kAccelerationLimit, Fact::kAccelerationLimit},
};

struct TransitionRow {
  PowerState from{};
  PowerCommand command{};
  PowerState to{};
};

// clang-format off
constexpr std::array kTransitions{
    TransitionRow{PowerState::switch_on_disabled, PowerCommand::shutdown, PowerState::ready_to_switch_on},         // 2
    TransitionRow{PowerState::ready_to_switch_on, PowerCommand::switch_on, PowerState::switched_on},               // 3
    TransitionRow{PowerState::ready_to_switch_on, PowerCommand::enable_operation, PowerState::operation_enabled},  // 3 and 4
    TransitionRow{PowerState::ready_to_switch_on, PowerCommand::disable_voltage, PowerState::switch_on_disabled},  // 7
    TransitionRow{PowerState::ready_to_switch_on, PowerCommand::quick_stop, PowerState::switch_on_disabled},       // 7
    TransitionRow{PowerState::switched_on, PowerCommand::enable_operation, PowerState::operation_enabled},         // 4
    TransitionRow{PowerState::switched_on, PowerCommand::shutdown, PowerState::ready_to_switch_on},                // 6
    TransitionRow{PowerState::switched_on, PowerCommand::disable_voltage, PowerState::switch_on_disabled},         // 10
    TransitionRow{PowerState::switched_on, PowerCommand::quick_stop, PowerState::switch_on_disabled},              // 10
    TransitionRow{PowerState::operation_enabled, PowerCommand::switch_on, PowerState::switched_on},                // 5
    TransitionRow{PowerState::operation_enabled, PowerCommand::shutdown, PowerState::ready_to_switch_on},          // 8
    TransitionRow{PowerState::operation_enabled, PowerCommand::disable_voltage, PowerState::switch_on_disabled},   // 9
    TransitionRow{PowerState::operation_enabled, PowerCommand::quick_stop, PowerState::quick_stop_active},         // 11
    TransitionRow{PowerState::quick_stop_active, PowerCommand::disable_voltage, PowerState::switch_on_disabled},   // 12
    TransitionRow{PowerState::fault, PowerCommand::fault_reset, PowerState::switch_on_disabled},                   // 15
};

// clang-format on

/// @return what a master that has commanded the transition to `state` waits for.
Waiting waiting_for(PowerState state) {
  switch (state) {
    case PowerState::switch_on_disabled:
      return Waiting::switch_on_disabled;
    case PowerState::ready_to_switch_on:
      return Waiting::ready_to_switch_on;
    case PowerState::switched_on:
      return Waiting::switched_on;
    case PowerState::operation_enabled:
      return Waiting::operation_enabled;
    case PowerState::quick_stop_active:
      return Waiting::quick_stop;
    default:
      return Waiting::nothing;
  }
}

}  // namespace

PowerState state_after(PowerState state, PowerCommand command) noexcept {
  const auto row = std::ranges::find_if(kTransitions, [&](const TransitionRow& candidate) {
    return candidate.from == state && candidate.command == command;
  });
  return row == kTransitions.end() ? state : row->to;
}

void KnownValues::set(ObjectAddress object, std::int64_t value) {
  const auto place = std::ranges::lower_bound(values_, object, {}, [](const auto& entry) {
    return entry.first;
  });
  if (place != values_.end() && place->first == object) {
    place->second = value;
  } else if (values_.size() < kMost) {
    values_.insert(place, {object, value});
  }
}

std::optional<std::int64_t> KnownValues::find(ObjectAddress object) const noexcept {
  const auto place = std::ranges::lower_bound(values_, object, {}, [](const auto& entry) {
    return entry.first;
  });
  if (place == values_.end() || place->first != object) return std::nullopt;
  return place->second;
}

void AxisTrack::note_value(ObjectAddress object, std::int64_t value) {
  for (const FactOfObject& row : kFactsOfValues) {
    if (row.object == object) facts |= row.fact;
  }
  values.set(object, value);
}

void AxisTrack::apply(const Write& write, Time now) {
  if (write.object == objects::kControlword) facts |= Fact::kControlword;
  if (write.channel == Channel::frame || write.channel == Channel::request) {
    facts |= Fact::kSessions | Fact::kLateness;
  }
  if (!is_taken(write)) return;
  if (write.object == objects::kControlword) {
    const auto word = static_cast<std::uint16_t>(write.value);
    const PowerCommand decoded = decode_command(word, controlword);
    if (decoded != PowerCommand::none) {
      command = decoded;
      if (has_status) expected = state_after(expected, decoded);
    }
    controlword = word;
    controlword_time = now;
    has_controlword = true;
  } else if (write.object == objects::kTarget) {
    target = static_cast<std::int32_t>(write.value);
    target_time = now;
  } else if (write.object == objects::kMode) {
    const auto wanted = static_cast<std::int8_t>(write.value);
    if (mode_wanted != wanted) mode_wanted_time = now;
    mode_wanted = wanted;
    facts |= Fact::kMode;
  } else {
    note_value(write.object, write.value);
  }
}

void AxisTrack::apply(const Reading& reading) {
  if (reading.is_of_the_master) facts |= Fact::kReads;
  if (reading.code != 0) return;
  // A controlword from before the source started still matters: the edges of the next one are
  // relative to it.
  if (reading.object == objects::kControlword) {
    if (!has_controlword) controlword = static_cast<std::uint16_t>(reading.value);
    has_controlword = true;
  } else if (reading.object == objects::kTarget) {
    if (!target) target = static_cast<std::int32_t>(reading.value);
  } else {
    note_value(reading.object, reading.value);
  }
}

void AxisTrack::apply(const Shown& shown, Time now) {
  if (shown.has(ShownMember::kMode)) {
    if (mode_shown != shown.mode) mode_since = now;
    mode_shown = shown.mode;
    mode_shown_time = now;
    is_mode_pushed = is_mode_pushed || !shown.is_asked_for;
    facts |= Fact::kMode | Fact::kModeShown;
  }
  if (shown.has(ShownMember::kPosition)) note_position(shown.position, now);
  if (shown.has(ShownMember::kDemand)) demand = shown.demand;
  if (shown.has(ShownMember::kFollowingError)) {
    following_error = shown.following_error;
    facts |= Fact::kFollowingError;
  }
  if (shown.has(ShownMember::kTorque)) {
    torque = shown.torque;
    facts |= Fact::kTorque;
  }
  if (shown.has(ShownMember::kErrorCode)) error_code = shown.error_code;
  if (shown.has(ShownMember::kStatusword)) apply_statusword(shown, now);
}

void AxisTrack::apply_statusword(const Shown& shown, Time now) {
  facts |= Fact::kStatusword;
  const bool is_known = has_status && shown.statusword == statusword;
  const PowerState decoded = is_known ? state : decode_power_state(shown.statusword);
  state_before = has_status ? state : decoded;
  if (!has_status || decoded != state) {
    state_since = now;
    expected = decoded;
  }
  state = decoded;
  statusword = shown.statusword;
  status_time = now;
  has_status = true;
  is_status_pushed = is_status_pushed || !shown.is_asked_for;
}

bool AxisTrack::apply(const Network& network, Time now) {
  facts |= Fact::kNodeState;
  const bool is_operational = network.state == NodeState::operational;
  const bool was_operational =
      node_state ? *node_state == NodeState::operational : is_status_pushed;
  // A heartbeat that was in transit when the node was started.
  const bool is_old = !network.is_command && network.state == NodeState::pre_operational &&
                      was_operational && started && now - *started < kStartTime;
  if (is_old) return false;
  if (network.is_command && is_operational) {
    started = now;
  } else if (!is_operational) {
    started.reset();
  }
  if (is_operational) {
    left_operational.reset();
  } else if (was_operational) {
    left_operational = now;
  }
  const bool is_new = node_state != network.state;
  node_state = network.state;
  return is_new;
}

void AxisTrack::note_position(std::int32_t now_at, Time now) {
  facts |= Fact::kPosition;
  if (!position) {
    lowest_ = highest_ = now_at;
    steps_ = {};
  }
  std::copy(steps_.begin() + 1, steps_.end(), steps_.begin());
  steps_.back() = std::int64_t{now_at} - position.value_or(now_at);
  lowest_ = std::min(lowest_, now_at);
  highest_ = std::max(highest_, now_at);
  position = now_at;
  position_time = now;
}

void AxisTrack::forget() {
  has_status = false;
  mode_shown.reset();
  mode_wanted.reset();
  position.reset();
  target.reset();
  has_controlword = false;
  controlword = 0;
  command = PowerCommand::none;
}

void AxisTrack::restart() {
  forget();
  values = {};
  error_code = 0;
  is_status_pushed = false;
  is_mode_pushed = false;
}

std::optional<std::int8_t> AxisTrack::mode_in_force() const noexcept {
  const bool is_current =
      mode_shown && (is_mode_pushed || !mode_wanted || mode_shown_time >= mode_wanted_time);
  return is_current ? mode_shown : mode_wanted;
}

bool AxisTrack::is_cyclic() const noexcept {
  const auto mode = mode_in_force();
  return mode && *mode >= static_cast<std::int8_t>(OperatingMode::interpolated_position) &&
         *mode <= static_cast<std::int8_t>(OperatingMode::cyclic_synchronous_torque);
}

bool AxisTrack::is_moving(Time now) const noexcept {
  if (!position || now - position_time > kFreshPosition) return false;
  const bool is_up = std::ranges::all_of(steps_, [](std::int64_t step) {
    return step > 0;
  });
  const bool is_down = std::ranges::all_of(steps_, [](std::int64_t step) {
    return step < 0;
  });
  if ((!is_up && !is_down) || std::abs(steps_.back()) < kMovingStep) return false;
  const std::int64_t way = std::abs(std::accumulate(steps_.begin(), steps_.end(), std::int64_t{0}));
  const std::int64_t range = std::int64_t{highest_} - lowest_;
  if (way < std::max(kMovingWay, range / kMovingShare)) return false;
  if (is_in(OperatingMode::profile_position) || is_in(OperatingMode::homing)) {
    return !shows(Statusword::kTargetReached);
  }
  if (is_in(OperatingMode::profile_velocity)) return !shows(Statusword::kSpeedZero);
  return true;
}

bool AxisTrack::is_near(std::int64_t place) const noexcept {
  if (!position) return false;
  std::int64_t at = *position;
  const auto was_near = [&](std::int64_t step) {
    return std::abs(place - std::exchange(at, at - step)) <= kSmallJump;
  };
  return std::any_of(steps_.rbegin(), steps_.rend(), was_near) ||
         std::abs(place - at) <= kSmallJump;
}

Waiting AxisTrack::waiting() const noexcept {
  if (!has_status) return Waiting::nothing;
  if (expected != state) return waiting_for(expected);
  if (mode_wanted && mode_shown && *mode_wanted != *mode_shown) return Waiting::mode;
  if (state != PowerState::operation_enabled) return Waiting::nothing;
  if (is_in(OperatingMode::homing)) return waiting_in_homing();
  return is_in(OperatingMode::profile_position) ? waiting_for_set_point() : Waiting::nothing;
}

Waiting AxisTrack::waiting_in_homing() const noexcept {
  constexpr std::uint16_t kEnded = Statusword::kHomingAttained | Statusword::kHomingError;
  const bool runs = commands(Controlword::kStartHoming) && (statusword & kEnded) == 0;
  return runs ? Waiting::homing : Waiting::nothing;
}

Waiting AxisTrack::waiting_for_set_point() const noexcept {
  const bool is_bit_4_up = commands(Controlword::kNewSetPoint);
  const bool is_acknowledged = shows(Statusword::kSetPointAcknowledge);
  if (is_bit_4_up && !is_acknowledged) return Waiting::acknowledge;
  if (!is_bit_4_up && is_acknowledged) return Waiting::acknowledge_gone;
  return shows(Statusword::kTargetReached) ? Waiting::nothing : Waiting::arrival;
}

}  // namespace vdrive::judge
