// SPDX-License-Identifier: Apache-2.0
#include "simulation/axis_watch.hpp"

#include "support/axis_invariants.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vdrive::simulation {
namespace {

/// The strongest acceleration that motor and test load torque together give the default axis:
/// (9 N.m + 3 N.m) / 6e-4 kg.m2 = 20000 rad/s2, times 4096 / 2 pi.
constexpr double kStrongest = 1.4e7;  // [UU/s2]

/// Of a jump, beside its speed and acceleration: rounding, and the noise of an encoder.
constexpr double kBlur = 6.0;  // [UU]

constexpr double kSettled_s = 0.5;
constexpr std::size_t kEncoderFailure = 4;

std::int64_t distance(std::int32_t from, std::int32_t to) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(to) -
                                   static_cast<std::uint32_t>(from));
}

bool is_mode(const AxisStatus& status, OperatingMode mode) {
  return static_cast<OperatingMode>(status.op_mode_actual) == mode;
}

/// The loop of the position is closed in the motions of the mode; in its stops it always may be.
bool leads_position(const AxisStatus& status) {
  using enum OperatingMode;
  return is_mode(status, none) || is_mode(status, profile_position) || is_mode(status, homing) ||
         is_mode(status, interpolated_position) || is_mode(status, cyclic_synchronous_position);
}

bool leads_torque(const AxisStatus& status) {
  const auto* const row = find_operating_mode(static_cast<OperatingMode>(status.op_mode_actual));
  return row != nullptr && row->commands_torque;
}

/// The profiles of 6086h lead the demand.
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

}  // namespace

void AxisWatch::begin(const AxisStatus& now, PowerState state) {
  last_ = now;
  last_state_ = state;
  is_contained_ = false;
  calm_s_ = 0.0;
  rest_speed_ = -1;
  since_word_s_ = 0.0;  // a restored axis may hold back a word
  last_change_ = 0;
  standing_ticks_ = 0;
  is_rounded_ = false;
}

void AxisWatch::check(const AxisStatus& now, PowerState state, const AxisCauses& causes,
                      const Registers& registers, bool restored, Happenings& happenings) {
  if (const char* const violated = test::violated_invariant(now, state, limits_.maker_bits)) {
    happenings.fail(violated, number_, std::string(to_string(state)),
                    "6041h " + number(now.ds402_statusword) + " 603Fh " + number(now.error_code) +
                        " 3005h " + number(now.motor_op_status) + " 606Bh " +
                        number(now.velocity_demand_value) + " 6077h " +
                        number(now.torque_actual_value));
  }
  if (restored) {
    begin(now, state);
    had_test_input_ = true;
    return;
  }
  has_test_input_ = registers.has_test_input();
  since_word_s_ = causes.commanded ? 0.0 : since_word_s_ + period_s_;
  const bool commanded = since_word_s_ <= limits_.delay;
  check_jump(now, registers, commanded, happenings);
  check_rest(now, happenings);
  check_speed(now, happenings);
  check_jerk(now, causes, happenings);
  check_range(now, commanded, happenings);
  check_modulo(now, happenings);
  check_torque(now, happenings);
  check_state(now, state, causes, commanded, happenings);
  had_test_input_ = has_test_input_;
  last_ = now;
  last_state_ = state;
}

/// On a modulo axis the shorter one round its range.
std::int64_t AxisWatch::way(std::int32_t from, std::int32_t to) const {
  const std::int64_t span = limits_.range_span;
  if (span == 0) return distance(from, to);
  const std::int64_t ahead = ((std::int64_t{to} - from) % span + span) % span;
  return ahead > span / 2 ? ahead - span : ahead;
}

/// The position moves with the speed. Homing sets it anew, a failed encoder gives no position.
void AxisWatch::check_jump(const AxisStatus& now, const Registers& registers, bool commanded,
                           Happenings& happenings) const {
  if (is_mode(now, OperatingMode::homing) || is_mode(last_, OperatingMode::homing) ||
      registers.test_inputs[kEncoderFailure] != 0 || had_test_input_) {
    return;
  }
  const auto furthest = static_cast<std::int64_t>(
      static_cast<double>(std::max(speed_of(last_), speed_of(now))) * period_s_ +
      kStrongest * period_s_ * period_s_ + kBlur);
  const std::int64_t moved = way(last_.load_position_actual_value, now.load_position_actual_value);
  if (std::abs(moved) > furthest) {
    happenings.fail(Invariant::kNoJump, number_, "at most " + number(furthest) + " UU in the tick",
                    number(moved) + motion_of(last_) + motion_of(now));
  }
  // The demand leaves its place at the speed limit at most, or brakes from above it. Where the
  // drive takes control anew, by command or of another loop, it begins at the actual position;
  // modes of velocity and torque change loops by themselves.
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
    happenings.fail(Invariant::kNoJump, number_,
                    "6062h at most " + number(furthest_demand) + " UU in the tick",
                    number(demanded) + motion_of(last_) + motion_of(now));
  }
}

/// Without power nothing but friction acts on a rigid axis: it never gets faster. A weight, cogging
/// and noise are something.
void AxisWatch::check_rest(const AxisStatus& now, Happenings& happenings) {
  if (now.motor_op_status != 0 || has_test_input_ || had_test_input_ || limits_.is_pushed) {
    rest_speed_ = -1;
    return;
  }
  if (rest_speed_ >= 0 && speed_of(now) > rest_speed_ + 1) {
    happenings.fail(Invariant::kNoMotion, number_, "at most " + number(rest_speed_) + " UU/s",
                    number(speed_of(now)));
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
/// it only falls. The actual speed may be above it for as long as a loop needs to settle; an axis
/// that a load drove far beyond it, for as long as the drive brakes with all its torque.
void AxisWatch::check_speed(const AxisStatus& now, Happenings& happenings) {
  const std::int64_t demand = std::abs(std::int64_t{now.velocity_demand_value});
  const std::int64_t demand_before = std::abs(std::int64_t{last_.velocity_demand_value});
  const std::int64_t highest = std::max({limits_.speed, demand_before, speed_of(last_)});
  if (demand > highest + 1) {
    happenings.fail(Invariant::kSpeed, number_, "606Bh at most " + number(highest), number(demand));
  }
  const bool is_led = now.motor_op_status == 1 && !leads_torque(now) && !has_test_input_;
  calm_s_ = is_led && !brakes_at_its_limit(now) ? calm_s_ + period_s_ : 0.0;
  const std::int64_t tolerated = limits_.speed + limits_.speed / 4 + 4'000;
  if (calm_s_ > kSettled_s && speed_of(now) > tolerated) {
    happenings.fail(Invariant::kSpeed, number_, "606Ch at most " + number(tolerated),
                    number(speed_of(now)) + motion_of(last_));
  }
}

/// Stops at limit switches have no limited jerk, nor have those that end Operation enabled. The
/// statuses of two ticks do not show that an axis was without power between them: transition 4 then
/// begins with a demand at rest.
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

/// From a demand that has stood on, as long as profiles alone lead it, the velocity changes from
/// tick to tick by at most jerk x period² more or less than in the tick before: its second
/// difference. It has two units of rounding, of three whole values.
void AxisWatch::check_jerk(const AxisStatus& now, const AxisCauses& causes,
                           Happenings& happenings) {
  constexpr int kStandingTicks = 3;
  constexpr double kRounding = 3.0;
  const std::int64_t change = std::int64_t{now.velocity_demand_value} - last_.velocity_demand_value;
  if (!may_be_rounded(now, causes)) {
    is_rounded_ = false;
    standing_ticks_ = 0;
  } else if (is_rounded_) {
    const auto most = static_cast<std::int64_t>(limits_.jerk * period_s_ * period_s_ + kRounding);
    if (std::abs(change - last_change_) > most) {
      happenings.fail(Invariant::kJerk, number_,
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

/// A demand that began at rest within the range and was led by profiles only stays there. A
/// streamed one stays while it follows: it needs no ramp to stop at the end, but a stop from its
/// speed does.
void AxisWatch::check_range(const AxisStatus& now, bool commanded, Happenings& happenings) {
  if (!limits_.has_range) return;
  const bool streams = is_mode(now, OperatingMode::cyclic_synchronous_position) ||
                       is_mode(now, OperatingMode::interpolated_position);
  const bool follows = streams && (now.ds402_statusword & Statusword::kFollowsCommand) != 0;
  const bool is_led = now.motor_op_status == 1 &&
                      (is_mode(now, OperatingMode::profile_position) || follows) &&
                      decode_power_state(now.ds402_statusword) == PowerState::operation_enabled;
  const bool is_inside =
      now.position_demand_value >= limits_.lower && now.position_demand_value <= limits_.upper;
  // A drive that is enabled anew begins at the actual position, which may have swung beyond.
  const bool begins = now.op_mode_actual != last_.op_mode_actual || (commanded && !is_inside);
  if (!is_led || begins) {
    is_contained_ = false;
  } else if (is_contained_ && !is_inside) {
    happenings.fail(Invariant::kRange, number_,
                    "6062h within " + number(limits_.lower) + " to " + number(limits_.upper),
                    number(now.position_demand_value) + motion_of(last_) + motion_of(now));
  } else {
    is_contained_ = is_contained_ || (is_inside && now.velocity_demand_value == 0);
  }
}

/// Positions of a modulo axis are below the upper limit, which is the lower one.
void AxisWatch::check_modulo(const AxisStatus& now, Happenings& happenings) const {
  if (limits_.range_span == 0) return;
  for (const std::int64_t position : {now.position_demand_value, now.load_position_actual_value}) {
    const std::int64_t place = position - limits_.range_lower;
    if (place < 0 || place >= limits_.range_span) {
      happenings.fail(Invariant::kModulo, number_,
                      number(limits_.range_lower) + " to below " +
                          number(limits_.range_lower + limits_.range_span),
                      number(position) + motion_of(now));
    }
  }
}

void AxisWatch::check_torque(const AxisStatus& now, Happenings& happenings) const {
  for (const std::int64_t torque : {now.torque_demand, now.torque_actual_value}) {
    if (torque > limits_.positive_torque + 1 || torque < -limits_.negative_torque - 1) {
      happenings.fail(Invariant::kTorque, number_,
                      number(-limits_.negative_torque) + " to " + number(limits_.positive_torque),
                      number(torque));
    }
  }
}

void AxisWatch::check_state(const AxisStatus& now, PowerState state, const AxisCauses& causes,
                            bool commanded, Happenings& happenings) const {
  constexpr std::uint16_t kBothBits = Statusword::kHomingAttained | Statusword::kHomingError;
  if (is_mode(now, OperatingMode::homing) && state == PowerState::operation_enabled &&
      (now.ds402_statusword & kBothBits) == kBothBits) {
    happenings.fail(Invariant::kHoming, number_, "one of them", motion_of(now));
  }
  const bool was_faulty = last_state_ == PowerState::fault;
  const bool enables = state == PowerState::operation_enabled && state != last_state_;
  if ((enables || (was_faulty && state != last_state_)) && !commanded && !causes.cycled) {
    happenings.fail(Invariant::kResume, number_, std::string(to_string(last_state_)),
                    std::string(to_string(state)) + " without a controlword");
  }
  const bool was_active =
      last_state_ == PowerState::operation_enabled || last_state_ == PowerState::quick_stop_active;
  if (!causes.lost || !was_active || causes.commanded || causes.cycled) return;
  const bool is_faulty = state == PowerState::fault || state == PowerState::fault_reaction_active;
  const bool reacts = limits_.abort_connection == 0 ||
                      (limits_.abort_connection == 1 && is_faulty && now.error_code != 0) ||
                      (limits_.abort_connection > 1 && state != PowerState::operation_enabled);
  if (!reacts) {
    happenings.fail(Invariant::kReaction, number_,
                    "6007h = " + number(limits_.abort_connection) + " from " +
                        std::string(to_string(last_state_)),
                    std::string(to_string(state)) + " 603Fh " + number(now.error_code));
  }
}

}  // namespace vdrive::simulation
