// SPDX-License-Identifier: Apache-2.0
#include "support/programs/model.hpp"

#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace vdrive::test {
namespace {

/// The strongest acceleration of the default axis that motor and test load torque can cause
/// together: (9 N.m + 3 N.m) / 6e-4 kg.m2 = 20000 rad/s2, times 4096 / 2 pi.
constexpr double kStrongest = 1.4e7;  // [UU/s2]

/// How far a position may move in a tick beyond what speed and acceleration allow: rounding, and
/// encoder noise.
constexpr double kBlur = 6.0;  // [UU]

constexpr double kSettled_s = 0.5;

std::int64_t distance(std::int32_t from, std::int32_t to) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(to) -
                                   static_cast<std::uint32_t>(from));
}

bool is_mode(const AxisStatus& status, OperatingMode mode) {
  return static_cast<OperatingMode>(status.op_mode_actual) == mode;
}

/// @return whether motions in this mode use the position loop. Stops may use it in any mode.
bool leads_position(const AxisStatus& status) {
  using enum OperatingMode;
  return is_mode(status, none) || is_mode(status, profile_position) || is_mode(status, homing) ||
         is_mode(status, interpolated_position) || is_mode(status, cyclic_synchronous_position);
}

bool leads_torque(const AxisStatus& status) {
  const auto* const row = find_operating_mode(static_cast<OperatingMode>(status.op_mode_actual));
  return row != nullptr && row->commands_torque;
}

/// @return whether the profiles of 6086h shape the demand.
bool has_profile(const AxisStatus& status) {
  return is_mode(status, OperatingMode::profile_position) ||
         is_mode(status, OperatingMode::profile_velocity);
}

bool is_at_limit_switch(const AxisStatus& status) {
  constexpr unsigned kLimitSwitches = 3;  // bits 0 and 1 of 60FDh
  return (status.digital_inputs & kLimitSwitches) != 0;
}

std::int64_t speed_of(const AxisStatus& status) {
  return std::abs(std::int64_t{status.load_velocity_actual_value});
}

std::string number(std::int64_t value) {
  return std::to_string(value);
}

std::string motion_of(const AxisStatus& status) {
  return " (mode " + number(status.op_mode_actual) + " 6041h " + number(status.ds402_statusword) +
         " 6040h " + number(status.ds402_controlword) + " 606Bh " +
         number(status.velocity_demand_value) + " 606Ch " +
         number(status.load_velocity_actual_value) + " 60F4h " +
         number(status.load_position_error_value) + ")";
}

/// @return which of bits 10 and 12 of 6041h an axis may show in `state` and in the mode of 6061h.
std::uint16_t possible_mode_bits(PowerState state, std::int8_t mode) {
  constexpr std::uint16_t kBit12 = Statusword::kSetPointAcknowledge;
  if (state == PowerState::quick_stop_active) return Statusword::kTargetReached;
  const OperatingModeRow* const row = find_operating_mode(static_cast<OperatingMode>(mode));
  if (state != PowerState::operation_enabled || row == nullptr) return 0;
  const bool has_bit_12 =
      std::ranges::find(row->status_bits, kBit12, &BitName::bit) != row->status_bits.end();
  // With 5E20h:0A, bit 10 is also used in a mode without a target.
  const bool has_bit_10 =
      row->has_target || row->mode == OperatingMode::cyclic_synchronous_position;
  return static_cast<std::uint16_t>((has_bit_12 ? kBit12 : 0U) |
                                    (has_bit_10 ? Statusword::kTargetReached : 0U));
}

/// @return whether transitions without a controlword can lead from one state to the other in one
///         tick: 1 ends the start-up, 13 and 14 belong to a fault, 7 and 10 to a lost DC link, 12
///         to a quick stop, 5 and 8 end the ramps of 605Ch and 605Bh, 9 and 11 are the reactions of
///         6007h.
bool falls(PowerState from, PowerState to) {
  using enum PowerState;
  switch (from) {
    case not_ready_to_switch_on:
    case ready_to_switch_on:
    case switched_on:
    case quick_stop_active:
      return to == switch_on_disabled || is_fault(to);
    case switch_on_disabled:
      return is_fault(to);
    case operation_enabled:
      return to != not_ready_to_switch_on;
    default:
      return from == fault_reaction_active && to == fault;
  }
}

}  // namespace

const char* violated_invariant(const AxisStatus& status, PowerState expected,
                               std::int64_t maker_bits) {
  constexpr std::uint16_t kReservedBits = 0xC100;
  constexpr std::uint16_t kModeBits = Statusword::kTargetReached | Statusword::kSetPointAcknowledge;
  const PowerState state = decode_power_state(status.ds402_statusword);
  const bool may_be_powered = state == PowerState::operation_enabled ||
                              state == PowerState::quick_stop_active ||
                              state == PowerState::fault_reaction_active;
  const bool has_power = status.motor_op_status == 1;
  const auto shows = [&status](std::uint16_t bits) {
    return status.ds402_statusword & bits;
  };
  if (state != expected) return Invariant::kState;
  if ((shows(kReservedBits) & ~maker_bits) != 0) return Invariant::kReserved;
  if ((shows(kModeBits) & ~possible_mode_bits(state, status.op_mode_actual)) != 0) {
    return Invariant::kModeBits;
  }
  if (!is_operating_mode(status.op_mode_actual)) return Invariant::kMode;
  if (status.motor_op_status != 0 && !may_be_powered) return Invariant::kPower;
  if (!has_power && status.torque_actual_value != 0) return Invariant::kTorqueOff;
  if (!has_power && status.velocity_demand_value != 0) return Invariant::kDemand;
  return (status.error_code != 0) != is_fault(state) ? Invariant::kErrorCode : nullptr;
}

std::pair<AbortCode, const char*> write_to(AxisBank& bank, std::size_t axis, const Write& write) {
  const PowerState state = bank.power_state(axis);
  const std::int64_t value = bank.read(axis, write.object).value;
  const AbortCode code = bank.write(axis, write.object, write.value);
  const bool is_kept =
      bank.power_state(axis) == state && bank.read(axis, write.object).value == value;
  return {code, code == AbortCode::none || is_kept ? nullptr : Invariant::kRefused};
}

bool reacts_to_loss(std::int64_t option, PowerState before, PowerState after) {
  const bool is_active =
      before == PowerState::operation_enabled || before == PowerState::quick_stop_active;
  if (!is_active || option == 0) return true;
  return option == 1 ? is_fault(after) : after != PowerState::operation_enabled;
}

// ---- states ------------------------------------------------------------------------------------

void PowerModel::expect_enabling(std::uint64_t delay) {
  enabling_until_ = std::max(enabling_until_, next_tick_ + delay);
}

void PowerModel::expect_reset(std::uint64_t delay) {
  reset_until_ = std::max(reset_until_, next_tick_ + delay);
}

const char* PowerModel::check(const AxisStatus& now, PowerState state, bool cycled,
                              std::int64_t maker_bits) {
  const PowerState before = std::exchange(last_, state);
  const bool changes = state != before;
  const bool enables = changes && state == PowerState::operation_enabled;
  const bool leaves_fault = changes && before == PowerState::fault;
  const bool resumes = (enables && !may_enable()) || (leaves_fault && !may_reset() && !cycled);
  const bool is_led = may_enable() || may_reset() || cycled;
  ++next_tick_;
  if (const char* const violated = violated_invariant(now, state, maker_bits)) return violated;
  if (resumes) return Invariant::kResume;
  return changes && !is_led && !falls(before, state) ? Invariant::kTransition : nullptr;
}

// ---- limits and motion -------------------------------------------------------------------------

AxisWatch::AxisWatch(const AxisLimits& limits, std::chrono::microseconds period)
    : limits_(limits),
      period_s_(std::chrono::duration<double>(period).count()),
      delay_(static_cast<std::uint64_t>(limits.delay / period_s_)) {}

void AxisWatch::expect_command(std::uint64_t delay) {
  power_.expect_enabling(delay);
  power_.expect_reset(delay);
}

void AxisWatch::begin(const AxisStatus& now, PowerState state) {
  power_.begin(state);
  if (delay_ > 0) expect_command(delay_ - 1);  // a restored axis may be delaying a controlword
  last_ = now;
  last_state_ = state;
  is_contained_ = false;
  calm_s_ = 0.0;
  rest_speed_ = -1;
  last_change_ = 0;
  standing_ticks_ = 0;
  is_rounded_ = false;
}

void AxisWatch::fail(const char* invariant, std::string expected, std::string seen) {
  if (violation_) return;
  violation_ = {.invariant = invariant, .expected = std::move(expected), .seen = std::move(seen)};
}

void AxisWatch::check(const AxisStatus& now, PowerState state, const AxisCauses& causes) {
  if (causes.commanded) expect_command(delay_);
  if (causes.restored) power_.begin(state);
  const bool commanded = power_.may_enable();
  if (const char* const violated = power_.check(now, state, causes.cycled, limits_.maker_bits)) {
    fail(violated, std::string(to_string(last_state_)) + ", then " + std::string(to_string(state)),
         "603Fh " + number(now.error_code) + " 3005h " + number(now.motor_op_status) + " 6077h " +
             number(now.torque_actual_value) + motion_of(now));
  }
  if (causes.restored) {
    begin(now, state);
    had_test_input_ = true;
    return;
  }
  has_test_input_ = causes.has_test_input;
  check_jump(now, causes.encoder_fails, commanded);
  check_rest(now);
  check_speed(now);
  check_jerk(now, causes);
  check_range(now, commanded);
  check_modulo(now);
  check_torque(now);
  check_homing(now, state);
  check_reaction(now, state, causes);
  had_test_input_ = has_test_input_;
  last_ = now;
  last_state_ = state;
}

/// On a modulo axis, the shorter way around its range.
std::int64_t AxisWatch::way(std::int32_t from, std::int32_t to) const {
  const std::int64_t span = limits_.range_span;
  if (span == 0) return distance(from, to);
  const std::int64_t ahead = ((std::int64_t{to} - from) % span + span) % span;
  return ahead > span / 2 ? ahead - span : ahead;
}

/// The position changes only by its speed, except in homing, which redefines it, and with a failed
/// encoder, which gives none.
void AxisWatch::check_jump(const AxisStatus& now, bool encoder_fails, bool commanded) {
  if (is_mode(now, OperatingMode::homing) || is_mode(last_, OperatingMode::homing) ||
      encoder_fails || had_test_input_) {
    return;
  }
  const auto furthest = static_cast<std::int64_t>(
      static_cast<double>(std::max(speed_of(last_), speed_of(now))) * period_s_ +
      kStrongest * period_s_ * period_s_ + kBlur);
  const std::int64_t moved = way(last_.load_position_actual_value, now.load_position_actual_value);
  if (std::abs(moved) > furthest) {
    fail(Invariant::kNoJump, "at most " + number(furthest) + " UU in the tick",
         number(moved) + motion_of(last_) + motion_of(now));
  }
  // The demand moves at most at the speed limit, or brakes from a higher speed. When the drive
  // takes control again, by a command or with another loop, the demand starts at the actual
  // position. Velocity and torque modes change loops by themselves.
  const bool begins =
      commanded || now.op_mode_actual != last_.op_mode_actual || !leads_position(now);
  const std::int64_t error =
      begins ? std::abs(std::int64_t{last_.load_position_error_value}) : std::int64_t{0};
  const std::int64_t demanded = way(last_.position_demand_value, now.position_demand_value);
  const auto furthest_demand =
      static_cast<std::int64_t>(
          static_cast<double>(std::max({limits_.speed, speed_of(last_), speed_of(now),
                                        std::abs(std::int64_t{last_.velocity_demand_value})})) *
              period_s_ +
          kStrongest * period_s_ * period_s_ + kBlur) +
      error;
  const bool is_led = now.motor_op_status == 1 && last_.motor_op_status == 1;
  if (is_led && std::abs(demanded) > furthest_demand) {
    fail(Invariant::kNoJump, "6062h at most " + number(furthest_demand) + " UU in the tick",
         number(demanded) + motion_of(last_) + motion_of(now));
  }
}

/// Without power only friction acts on a rigid axis, so it never gets faster. This does not apply
/// with a weight, cogging or noise.
void AxisWatch::check_rest(const AxisStatus& now) {
  if (now.motor_op_status != 0 || has_test_input_ || had_test_input_ || limits_.is_pushed) {
    rest_speed_ = -1;
    return;
  }
  if (rest_speed_ >= 0 && speed_of(now) > rest_speed_ + 1) {
    fail(Invariant::kNoMotion, "at most " + number(rest_speed_) + " UU/s", number(speed_of(now)));
  }
  rest_speed_ = speed_of(now);
}

bool AxisWatch::brakes_at_its_limit(const AxisStatus& now) const {
  const bool is_strongest = now.load_velocity_actual_value < 0
                                ? now.torque_demand >= limits_.positive_torque - 1
                                : now.torque_demand <= 1 - limits_.negative_torque;
  return is_strongest && speed_of(now) < speed_of(last_);
}

/// The demand never exceeds the limit, unless the axis was faster when the drive took control; then
/// it only falls. The actual speed may exceed the limit while a loop settles or, on an axis that a
/// load drove far beyond it, while the drive brakes with full torque.
void AxisWatch::check_speed(const AxisStatus& now) {
  const std::int64_t demand = std::abs(std::int64_t{now.velocity_demand_value});
  const std::int64_t demand_before = std::abs(std::int64_t{last_.velocity_demand_value});
  const std::int64_t highest = std::max({limits_.speed, demand_before, speed_of(last_)});
  if (demand > highest + 1) {
    fail(Invariant::kSpeed, "606Bh at most " + number(highest), number(demand));
  }
  const bool is_led = now.motor_op_status == 1 && !leads_torque(now) && !has_test_input_;
  calm_s_ = is_led && !brakes_at_its_limit(now) ? calm_s_ + period_s_ : 0.0;
  const std::int64_t tolerated = limits_.speed + limits_.speed / 4 + 4'000;
  if (calm_s_ > kSettled_s && speed_of(now) > tolerated) {
    fail(Invariant::kSpeed, "606Ch at most " + number(tolerated),
         number(speed_of(now)) + motion_of(last_));
  }
}

/// Jerk is not limited in stops at limit switches and in stops that end Operation enabled. The
/// statuses of two ticks do not show whether the axis was without power in between; transition 4
/// then begins with a demand at rest.
bool AxisWatch::may_be_rounded(const AxisStatus& now, const AxisCauses& causes) const {
  constexpr int kDisableVoltage = 2;  // of 6007h
  const bool was_off = causes.switched_off || causes.cycled ||
                       (causes.lost && limits_.abort_connection == kDisableVoltage);
  return limits_.jerk > 0.0 && !was_off && now.motor_op_status == 1 && last_.motor_op_status == 1 &&
         last_state_ == PowerState::operation_enabled &&
         decode_power_state(now.ds402_statusword) == PowerState::operation_enabled &&
         now.op_mode_actual == last_.op_mode_actual && has_profile(now) &&
         !is_at_limit_switch(now) && !is_at_limit_switch(last_) && !has_test_input_ &&
         !had_test_input_;
}

/// Once the demand has rested, and as long as only profiles shape it, the change of velocity per
/// tick differs from that of the previous tick by at most jerk x period² (second difference). Three
/// rounded values add two units of rounding.
void AxisWatch::check_jerk(const AxisStatus& now, const AxisCauses& causes) {
  constexpr int kStandingTicks = 3;
  constexpr double kRounding = 3.0;
  const std::int64_t change = std::int64_t{now.velocity_demand_value} - last_.velocity_demand_value;
  if (!may_be_rounded(now, causes)) {
    is_rounded_ = false;
    standing_ticks_ = 0;
  } else if (is_rounded_) {
    const auto most = static_cast<std::int64_t>(limits_.jerk * period_s_ * period_s_ + kRounding);
    if (std::abs(change - last_change_) > most) {
      fail(Invariant::kJerk,
           "606Bh changes by " + number(last_change_) + " with at most " + number(most) +
               " UU/s more or less",
           number(change) + motion_of(last_) + motion_of(now));
    }
  } else {
    const bool stands = now.velocity_demand_value == 0 && change == 0;
    standing_ticks_ = stands ? standing_ticks_ + 1 : 0;
    is_rounded_ = standing_ticks_ >= kStandingTicks;
  }
  last_change_ = change;
}

/// A demand that started at rest within the range stays there as long as only profiles lead it. A
/// streamed demand stays there while the drive follows it, because it can stop at the limit without
/// a ramp; a stop reaction needs a ramp and may pass the limit.
void AxisWatch::check_range(const AxisStatus& now, bool commanded) {
  if (!limits_.has_range) return;
  const bool streams = is_mode(now, OperatingMode::cyclic_synchronous_position) ||
                       is_mode(now, OperatingMode::interpolated_position);
  const bool follows = streams && (now.ds402_statusword & Statusword::kFollowsCommand) != 0;
  const bool is_led = now.motor_op_status == 1 &&
                      (is_mode(now, OperatingMode::profile_position) || follows) &&
                      decode_power_state(now.ds402_statusword) == PowerState::operation_enabled;
  const bool is_inside =
      now.position_demand_value >= limits_.lower && now.position_demand_value <= limits_.upper;
  // When it is enabled again, the drive starts at the actual position, which may have swung beyond
  // the limit.
  const bool begins = now.op_mode_actual != last_.op_mode_actual || (commanded && !is_inside);
  if (!is_led || begins) {
    is_contained_ = false;
  } else if (is_contained_ && !is_inside) {
    fail(Invariant::kRange,
         "6062h within " + number(limits_.lower) + " to " + number(limits_.upper),
         number(now.position_demand_value) + motion_of(last_) + motion_of(now));
  } else {
    is_contained_ = is_contained_ || (is_inside && now.velocity_demand_value == 0);
  }
}

/// Positions of a modulo axis are below the upper limit, which is the same position as the lower
/// one.
void AxisWatch::check_modulo(const AxisStatus& now) {
  if (limits_.range_span == 0) return;
  for (const std::int64_t position : {now.position_demand_value, now.load_position_actual_value}) {
    const std::int64_t place = position - limits_.range_lower;
    if (place < 0 || place >= limits_.range_span) {
      fail(Invariant::kModulo,
           number(limits_.range_lower) + " to below " +
               number(limits_.range_lower + limits_.range_span),
           number(position) + motion_of(now));
    }
  }
}

void AxisWatch::check_torque(const AxisStatus& now) {
  for (const std::int64_t torque : {now.torque_demand, now.torque_actual_value}) {
    if (torque > limits_.positive_torque + 1 || torque < -limits_.negative_torque - 1) {
      fail(Invariant::kTorque,
           number(-limits_.negative_torque) + " to " + number(limits_.positive_torque),
           number(torque));
    }
  }
}

void AxisWatch::check_homing(const AxisStatus& now, PowerState state) {
  constexpr std::uint16_t kBothBits = Statusword::kHomingAttained | Statusword::kHomingError;
  if (is_mode(now, OperatingMode::homing) && state == PowerState::operation_enabled &&
      (now.ds402_statusword & kBothBits) == kBothBits) {
    fail(Invariant::kHoming, "one of them", motion_of(now));
  }
}

void AxisWatch::check_reaction(const AxisStatus& now, PowerState state, const AxisCauses& causes) {
  if (!causes.lost || causes.commanded || causes.cycled) return;
  if (!reacts_to_loss(limits_.abort_connection, last_state_, state)) {
    fail(Invariant::kReaction,
         "6007h = " + number(limits_.abort_connection) + " from " +
             std::string(to_string(last_state_)),
         std::string(to_string(state)) + " 603Fh " + number(now.error_code));
  }
}

}  // namespace vdrive::test
