// SPDX-License-Identifier: Apache-2.0
#include "judge/planted.hpp"

#include "judge/axis_track.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;
using Names = std::vector<std::string>;

constexpr ObjectAddress kBlockedLoad{0x5E01, 0};
constexpr ObjectAddress kOverCurrent{0x5E02, 0};
constexpr ObjectAddress kPositiveLimit{0x5E06, 0};
constexpr ObjectAddress kPowerOnTime{0x5E20, 7};
constexpr ObjectAddress kModeDelay{0x5E20, 8};
constexpr ObjectAddress kResetDelay{0x5E20, 9};
constexpr ObjectAddress kQuickStopOption{0x605A, 0};
constexpr ObjectAddress kProfileSpeed{0x6081, 0};
constexpr ObjectAddress kHomingMethod{0x6098, 0};

constexpr std::uint16_t kReset = 0x0080;

// ---- handshake ---------------------------------------------------------------------------------

Names second_set_point(bool waits) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  drive.target(1'000);
  drive.word(kSetPoint);
  drive.step(2);
  drive.word(kEnabled);
  if (waits) drive.step_until_bits(Statusword::kSetPointAcknowledge, 0);
  drive.target(2'000);
  drive.word(kSetPoint | Controlword::kChangeSetImmediately);
  drive.step(2);
  drive.word(kEnabled);
  drive.step(100);
  return drive.findings();
}

Names second_target(bool drops_bit_4) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  drive.target(1'000);
  drive.word(kSetPoint);
  drive.step(5);
  if (drops_bit_4) drive.word(kEnabled);
  if (drops_bit_4) drive.step(2);
  drive.target(2'000);
  drive.word(kSetPoint);
  drive.step(5);
  return drive.findings();
}

Names edge_before_target(bool target_first) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  if (target_first) drive.target(1'000);
  drive.word(kSetPoint);
  drive.step(2);
  if (!target_first) drive.target(1'000);
  drive.step(2);
  drive.word(kEnabled);
  drive.step(10);
  return drive.findings();
}

Names set_point_in_halt(bool resumes) {
  AxisConfiguration configuration;
  configuration.settings.acknowledge_while_halted = false;
  JudgedDrive drive({}, configuration);
  drive.enable(kProfilePosition);
  const std::uint16_t halt = resumes ? std::uint16_t{0} : Controlword::kHalt;
  drive.word(kEnabled | halt);
  drive.step(2);
  drive.target(1'000);
  drive.word(kSetPoint | halt);
  drive.step(200);
  drive.word(kEnabled | halt);
  drive.step(2);
  return drive.findings();
}

Names ignored_set_point(bool is_ignored) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  drive.target(1'000);
  drive.take(Write{.object = objects::kControlword,
                   .value = kSetPoint,
                   .fate = is_ignored ? Fate::ignored : Fate::accepted});
  return drive.findings();
}

Names enabling_with_bit_4(bool has_bit_4) {
  JudgedDrive drive;
  drive.mode(kProfilePosition);
  drive.step(2);
  drive.word(controlwords::kShutdown);
  drive.step(2);
  drive.word(controlwords::kSwitchOn);
  drive.step(2);
  drive.target(1'000);
  drive.word(has_bit_4 ? kSetPoint : kEnabled);
  drive.step(2);
  return drive.findings();
}

/// A new target every 10 ms, but an edge of bit 4 only every `cycles_of_an_edge` targets.
Names stream_by_handshake(std::uint32_t cycles_of_an_edge) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  for (std::uint32_t i = 1; i < 120; ++i) {
    drive.target(static_cast<std::int32_t>(10 * i));
    const bool is_up = i % cycles_of_an_edge == 0;
    drive.word(is_up ? kSetPoint | Controlword::kChangeSetImmediately : kEnabled);
    drive.step(5);
    if (is_up) drive.word(kEnabled);
    drive.step(5);
  }
  return drive.findings();
}

Names relative_after_absolute(bool keeps_bit_6) {
  const std::uint16_t between = keeps_bit_6 ? kEnabled | Controlword::kRelative : kEnabled;
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  drive.move(100);
  for (int i = 0; i < 3; ++i) {
    drive.target(100 + i);
    drive.word(kSetPoint | Controlword::kRelative);
    drive.step(2);
    drive.word(between);
    drive.step_until_bits(kReached, kReached);
  }
  return drive.findings();
}

Names pulse_of_bit_4(std::uint64_t ticks) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  drive.target(1'000);
  drive.word(kSetPoint);
  drive.step(ticks);
  drive.word(kEnabled);
  drive.step(10);
  return drive.findings();
}

// ---- power state machine -----------------------------------------------------------------------

Names first_word(std::uint16_t word) {
  JudgedDrive drive;
  drive.step(2);
  drive.word(word);
  drive.step(2);
  return drive.findings();
}

Names enabling_words(std::uint64_t ticks_between) {
  JudgedDrive drive;
  drive.step(2);
  for (const std::uint16_t word : {controlwords::kShutdown, controlwords::kSwitchOn, kEnabled}) {
    drive.word(word);
    drive.step(ticks_between);
  }
  drive.step(2);
  return drive.findings();
}

void fault_and_recovery(JudgedDrive& drive) {
  drive.disturb(kOverCurrent, 1);
  drive.step_until_state(PowerState::fault);
  drive.disturb(kOverCurrent, 0);
  drive.step(200);
}

Names reset_with_old_bit(bool was_up) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  if (was_up) drive.word(kEnabled | kReset);
  drive.step(2);
  fault_and_recovery(drive);
  drive.word(kEnabled | kReset);
  drive.step(20);
  return drive.findings();
}

Names resets(int count) {
  JudgedDrive drive;
  drive.step(2);
  drive.disturb(kOverCurrent, 1);
  drive.step(50);
  for (int i = 0; i < count; ++i) {
    drive.word(kReset);
    drive.step(20);
    drive.word(0);
    drive.step(20);
  }
  return drive.findings();
}

Names reset_after_reading(bool reads) {
  JudgedDrive drive({.shows_error_code = false});
  drive.enable(kProfilePosition);
  fault_and_recovery(drive);
  if (reads) drive.read(objects::kErrorCode);
  drive.word(kReset);
  drive.step(20);
  return drive.findings();
}

Names leave_quick_stop(std::uint16_t word) {
  JudgedDrive drive;
  drive.write(kQuickStopOption, 6);  // stays in Quick stop active
  drive.enable(kProfilePosition);
  drive.word(controlwords::kQuickStop);
  drive.step(20);
  drive.word(word);
  drive.step(20);
  return drive.findings();
}

Names power_off(bool stops_first, bool waits) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  drive.set_point(100'000);
  drive.step(200);
  if (stops_first) drive.word(kEnabled | Controlword::kHalt);
  if (stops_first) drive.step(5);
  if (waits) drive.step_until_bits(kReached, kReached);
  drive.word(controlwords::kDisableVoltage);
  drive.step(20);
  return drive.findings();
}

Names enabling_that_gives_up(bool gives_up) {
  JudgedDrive drive;
  drive.disturb(kPowerOnTime, 300);
  drive.step(2);
  drive.word(controlwords::kShutdown);
  drive.step_until_state(PowerState::ready_to_switch_on);
  drive.word(controlwords::kSwitchOn);
  drive.step_until_state(PowerState::switched_on);
  drive.word(kEnabled);
  if (gives_up) {
    drive.step(100);
  } else {
    drive.step_until_state(PowerState::operation_enabled);
  }
  drive.word(controlwords::kShutdown);
  drive.step(20);
  return drive.findings();
}

Names enabling_after_reset(bool waits) {
  JudgedDrive drive;
  drive.disturb(kResetDelay, 50);
  drive.enable(kProfilePosition);
  fault_and_recovery(drive);
  drive.word(kReset);
  drive.step(5);
  if (waits) drive.step_until_state(PowerState::switch_on_disabled);
  drive.word(waits ? controlwords::kShutdown : kEnabled);
  drive.step(5);
  return drive.findings();
}

Names second_reset(bool waits) {
  JudgedDrive drive;
  drive.disturb(kResetDelay, 50);
  drive.enable(kProfilePosition);
  fault_and_recovery(drive);
  drive.word(kReset);
  if (waits) drive.step(100);
  drive.word(0);
  if (!waits) drive.word(kReset);
  drive.step(100);
  return drive.findings();
}

// ---- modes -------------------------------------------------------------------------------------

Names mode_change(bool stands) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  drive.set_point(50'000);
  if (stands) {
    drive.step_until_bits(kReached, kReached);
  } else {
    drive.step(200);
  }
  drive.mode(kProfileVelocity);
  drive.step(20);
  return drive.findings();
}

Names mode_change_in_halt(bool halts) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  if (halts) drive.word(kEnabled | Controlword::kHalt);
  drive.step(20);
  drive.mode(kProfileVelocity);
  drive.step(20);
  return drive.findings();
}

Names edge_after_mode(bool waits) {
  JudgedDrive drive;
  drive.disturb(kModeDelay, 50);
  drive.enable(kProfileVelocity);
  drive.mode(kProfilePosition);
  drive.target(1'000);
  drive.step(waits ? 100 : 5);
  drive.word(kSetPoint);
  drive.step(5);
  drive.word(kEnabled);
  drive.step(100);
  return drive.findings();
}

Names edge_without_display(bool reads) {
  JudgedDrive drive({.shows_mode = false});
  drive.enable(kProfilePosition);
  drive.target(1'000);
  if (reads) drive.read(objects::kModeShown);
  drive.word(kSetPoint);
  drive.step(5);
  drive.word(kEnabled);
  drive.step(5);
  return drive.findings();
}

Names mode_again(int times) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  for (int i = 0; i < times; ++i) {
    drive.mode(kProfilePosition);
    drive.step(500);
  }
  return drive.findings();
}

Names velocities_in_mode(std::int8_t mode) {
  JudgedDrive drive;
  drive.enable(mode);
  for (int i = 1; i < 8; ++i) {
    drive.write(objects::kTargetVelocity, 100 * i);
    drive.step(10);
  }
  return drive.findings();
}

/// A homing run towards a switch that never comes.
Names long_homing(std::uint64_t ticks, bool waits_for_end) {
  JudgedDrive drive;
  drive.write(kHomingMethod, 17);
  drive.enable(kHoming);
  drive.word(kSetPoint);
  drive.step(ticks);
  if (waits_for_end) {
    drive.disturb({0x5E07, 0}, 1);
    drive.step(20);
    drive.disturb({0x5E07, 0}, 0);
    drive.step_until_bits(kAttained | kReached, kAttained | kReached);
  }
  drive.word(kEnabled);
  drive.step(20);
  return drive.findings();
}

Names second_homing(bool drops_bit_4) {
  JudgedDrive drive;
  drive.write(kHomingMethod, 37);
  drive.enable(kHoming);
  drive.word(kSetPoint);
  drive.step_until_bits(kAttained | kReached, kAttained | kReached);
  drive.step(5);
  if (drops_bit_4) drive.word(kEnabled);
  drive.step(5);
  drive.word(kSetPoint);
  drive.step(5);
  return drive.findings();
}

Names homing_with_bit_4_from_before(bool drops_bit_4) {
  JudgedDrive drive;
  drive.write(kHomingMethod, 37);
  drive.enable(kProfilePosition);
  drive.target(0);
  drive.word(kSetPoint);
  drive.step_until_bits(kReached, kReached);
  if (drops_bit_4) drive.word(kEnabled);
  drive.step(5);
  drive.mode(kHoming);
  drive.step(5);
  drive.word(kSetPoint | Controlword::kChangeSetImmediately);
  drive.step_until_bits(kAttained, kAttained, 2'000);
  return drive.findings();
}

Names homing_done_before(bool waits) {
  JudgedDrive drive;
  drive.write(kHomingMethod, 37);
  drive.enable(kHoming);
  drive.word(kSetPoint);
  drive.step_until_bits(kAttained, kAttained);
  drive.step(5);
  drive.word(kEnabled);
  drive.step(5);
  drive.word(kSetPoint);
  if (waits) drive.step(10);
  drive.mode(kProfilePosition);
  drive.step(10);
  return drive.findings();
}

// ---- motion ------------------------------------------------------------------------------------

Names target_at_limit(std::int32_t target) {
  JudgedDrive drive;
  drive.write(objects::kLowerLimit, -10'000);
  drive.write(objects::kUpperLimit, 10'000);
  drive.enable(kProfilePosition);
  drive.move(target);
  return drive.findings();
}

Names profile_speed(std::int64_t speed) {
  JudgedDrive drive;
  drive.write(objects::kSpeedLimit, 5'000);
  drive.write(kProfileSpeed, speed);
  drive.enable(kProfilePosition);
  drive.move(1'000);
  return drive.findings();
}

/// Sends targets in mode 8, one per tick.
class Stream {
 public:
  explicit Stream(JudgedDrive& drive) : drive_(drive) {
    at_ = drive.position();
    if (drive.status().op_mode_actual != kCyclicPosition || !drive.shows(0x27)) {
      drive.mode(kCyclicPosition);
      drive.step(2);
      drive.target(at_);
      drive.enable(kCyclicPosition);
    }
  }

  void go(std::int32_t step, int times) {
    for (int i = 0; i < times; ++i) {
      at_ += step;
      drive_.target(at_);
      drive_.step();
    }
  }

  /// Ramps from one speed to another, then keeps that for `times` ticks.
  void ramp(std::int32_t from, std::int32_t to, int times) {
    for (std::int32_t speed = from; speed != to; speed += to > from ? 1 : -1) go(speed, 1);
    go(to, times);
  }

  void jump(std::int32_t way) { at_ += way; }

 private:
  JudgedDrive& drive_;
  std::int32_t at_ = 0;
};

Names stream_with(void (*disturb)(Stream& stream, JudgedDrive& drive)) {
  JudgedDrive drive;
  drive.write(objects::kSpeedLimit, 100'000);
  Stream stream(drive);
  stream.ramp(0, 40, 60);
  disturb(stream, drive);
  stream.go(40, 20);
  stream.ramp(40, 0, 20);
  return drive.findings();
}

Names regular_stream() {
  return stream_with([](Stream& stream, JudgedDrive& /*drive*/) {
    stream.go(40, 10);
  });
}

/// The ramps add 1 unit per millisecond in each millisecond: 1,000,000 units/s².
Names stream_with_acceleration(std::int64_t limit) {
  JudgedDrive drive;
  drive.write(objects::kAccelerationLimit, limit);
  Stream stream(drive);
  stream.ramp(0, 40, 60);
  stream.go(40, 20);
  stream.ramp(40, 0, 60);
  return drive.findings();
}

/// 6080h = 100 rpm is 6,827 user units/s, with 4,096 per revolution.
Names stream_at_motor_speed(std::int32_t step) {
  JudgedDrive drive;
  drive.write({0x6080, 0}, 100);
  drive.write(objects::kSpeedLimit, 100'000);
  drive.take(
      Reading{.object = objects::kMotorSpeedLimit, .value = 6'827, .is_of_the_master = false});
  Stream stream(drive);
  stream.ramp(0, step, 60);
  stream.go(step, 40);
  stream.ramp(step, 0, 60);
  return drive.findings();
}

Names stream_with_jump() {
  return stream_with([](Stream& stream, JudgedDrive& /*drive*/) {
    stream.jump(400);
  });
}

Names stream_with_repeat() {
  return stream_with([](Stream& stream, JudgedDrive& /*drive*/) {
    stream.go(0, 1);
  });
}

Names stream_with_gap() {
  return stream_with([](Stream& stream, JudgedDrive& drive) {
    drive.step(3);
    stream.jump(120);
  });
}

Names stream_from(std::int32_t begin) {
  JudgedDrive drive;
  drive.mode(kCyclicPosition);
  drive.step(2);
  drive.target(begin);
  drive.enable(kCyclicPosition);
  for (std::int32_t i = 1; i < 60; ++i) {
    drive.target(begin + 5 * i);
    drive.step();
  }
  return drive.findings();
}

/// At 2,000 units/s: the axis, blocked for 1.5 s, lags by 3,000 units.
Names move_within_window(bool is_blocked) {
  JudgedDrive drive;
  drive.write(objects::kFollowingWindow, 5'000);
  drive.write(kProfileSpeed, 2'000);
  drive.enable(kProfilePosition);
  drive.disturb(kBlockedLoad, is_blocked ? 1 : 0);
  drive.set_point(20'000);
  drive.step(1'500);
  return drive.findings();
}

Names move_with_blocked_load(bool is_blocked) {
  JudgedDrive drive;
  drive.write(objects::kMaxTorque, 300);
  drive.write(kProfileSpeed, 2'000);
  drive.enable(kProfilePosition);
  drive.disturb(kBlockedLoad, is_blocked ? 1 : 0);
  drive.set_point(10'000);
  drive.step(3'000);
  return drive.findings();
}

Names stream_after_homing(bool reads_position_again) {
  JudgedDrive drive;
  drive.write(kHomingMethod, 37);
  Stream stream(drive);
  stream.ramp(0, 40, 200);
  stream.ramp(40, 0, 200);
  const std::int32_t before = drive.position();
  drive.mode(kHoming);
  drive.step(5);
  drive.word(kSetPoint);
  drive.step_until_bits(kAttained, kAttained);
  drive.word(kEnabled);
  drive.step(5);
  drive.mode(kCyclicPosition);
  drive.step(2);
  const std::int32_t begin = reads_position_again ? drive.position() : before;
  for (std::int32_t i = 1; i < 60; ++i) {
    drive.target(begin + i);
    drive.step();
  }
  return drive.findings();
}

Names late_set_point(bool is_late) {
  JudgedDrive drive;
  drive.enable(kCyclicPosition);
  drive.take(Write{.object = objects::kTarget,
                   .value = drive.position(),
                   .channel = Channel::frame,
                   .fate = is_late ? Fate::late : Fate::accepted});
  return drive.findings();
}

// ---- writers, PDOs, SYNC -----------------------------------------------------------------------

Names words_beside_pdo(Channel channel) {
  JudgedDrive drive;
  drive.step(2);
  for (int i = 0; i < 10; ++i) {
    drive.word(controlwords::kShutdown, Channel::pdo);
    drive.step(10);
  }
  drive.word(controlwords::kSwitchOn, channel);
  drive.step(10);
  drive.word(channel == Channel::sdo ? controlwords::kShutdown : controlwords::kSwitchOn,
             Channel::pdo);
  drive.step(10);
  return drive.findings();
}

Names words_of(std::array<std::uint64_t, 3> sessions) {
  JudgedDrive drive;
  drive.step(2);
  drive.word(controlwords::kShutdown, Channel::request, sessions[0]);
  drive.step(10);
  drive.word(controlwords::kSwitchOn, Channel::request, sessions[1]);
  drive.step(10);
  drive.word(controlwords::kShutdown, Channel::request, sessions[2]);
  drive.step(10);
  return drive.findings();
}

Names pdo_in(NodeState state) {
  JudgedDrive drive;
  drive.take(Network{.state = NodeState::pre_operational});
  drive.take(Network{.state = state, .is_command = true});
  drive.step(250);  // longer than a PDO can be in transit
  drive.take(ReceivePdo{.number = 1});
  drive.word(controlwords::kShutdown, Channel::pdo);
  drive.step(10);
  return drive.findings();
}

/// Mode 8 by PDOs, with a SYNC every 10 ms.
Names synchronous_stream(std::uint8_t type, std::int64_t period, int pdos_a_cycle, bool has_sync,
                         bool is_regular = true) {
  JudgedDrive drive;
  drive.write(objects::kCyclePeriod, period);
  drive.take(Reading{.object = objects::kCyclePeriod, .value = period, .is_of_the_master = false});
  drive.enable(kCyclicPosition);
  for (int i = 0; i < 400; ++i) {
    if (has_sync) drive.take(Sync{});
    for (int k = 0; k < pdos_a_cycle; ++k) {
      drive.take(ReceivePdo{.number = 1, .type = type});
      drive.target(drive.position(), Channel::pdo);
    }
    // 2 of 10 cycles are shifted: one lasts half as long, the next one and a half times as long.
    const std::uint64_t shift = is_regular ? 0 : (i % 10 == 0 ? 5 : 0);
    drive.step(i % 10 == 1 && !is_regular ? 15 : 10 - shift);
  }
  return drive.findings();
}

// ---- supervision -------------------------------------------------------------------------------

Names stream_through_fault(bool ends) {
  JudgedDrive drive;
  Stream stream(drive);
  stream.ramp(0, 20, 60);
  drive.disturb(kOverCurrent, 1);
  stream.go(20, ends ? 20 : 600);
  drive.step(600);
  return drive.findings();
}

Names stream_through_fall(bool ends) {
  JudgedDrive drive;
  Stream stream(drive);
  stream.ramp(0, 20, 60);
  drive.pretend(PowerState::switched_on);
  drive.disturb(kBlockedLoad, 1);  // without power the axis stands still
  stream.go(20, ends ? 20 : 900);
  drive.step(600);
  return drive.findings();
}

Names stream_into_limit(bool ends) {
  JudgedDrive drive;
  Stream stream(drive);
  stream.ramp(0, 5, 60);
  drive.disturb(kPositiveLimit, 1);
  stream.go(5, ends ? 20 : 400);
  stream.go(0, 400);
  return drive.findings();
}

Names signs_of_life(std::uint64_t distance) {
  JudgedDrive drive;
  for (int i = 0; i < 10; ++i) {
    drive.take(KeepAlive{.limit = 100ms});
    drive.step(distance);
  }
  return drive.findings();
}

Names stores(std::uint64_t distance) {
  JudgedDrive drive;
  constexpr std::int64_t kSave = 0x65766173;
  drive.write(objects::kStore, kSave);
  drive.step(distance);
  drive.write(objects::kStore, kSave);
  return drive.findings();
}

Names end_of_run(bool disables) {
  JudgedDrive drive;
  drive.enable(kProfilePosition);
  if (disables) drive.disable();
  return drive.findings(true);
}

Names nmt_stop(bool disables) {
  JudgedDrive drive;
  drive.take(Network{.state = NodeState::operational});
  drive.enable(kProfilePosition);
  if (disables) drive.disable();
  drive.take(Network{.state = NodeState::stopped, .is_command = true});
  return drive.findings();
}

#define MASTER(call) \
  [] {               \
    return call;     \
  }

// clang-format off
const std::vector<Planted>& rows() {
  static const std::vector<Planted> planted{
    {Rule::handshake_before_acknowledge_fell, MASTER(second_set_point(false)), MASTER(second_set_point(true))},
    {Rule::handshake_no_edge, MASTER(second_target(false)), MASTER(second_target(true))},
    {Rule::handshake_target_after_edge, MASTER(edge_before_target(false)), MASTER(edge_before_target(true))},
    {Rule::handshake_not_taken, MASTER(set_point_in_halt(false)), MASTER(set_point_in_halt(true))},
    {Rule::handshake_not_taken, MASTER(ignored_set_point(true)), MASTER(ignored_set_point(false))},
    {Rule::handshake_not_enabled, MASTER(enabling_with_bit_4(true)), MASTER(enabling_with_bit_4(false))},
    {Rule::handshake_stream, MASTER(stream_by_handshake(3)), MASTER(stream_by_handshake(1))},
    {Rule::handshake_relative_stays, MASTER(relative_after_absolute(true)), MASTER(relative_after_absolute(false))},
    {Rule::handshake_short_pulse, MASTER(pulse_of_bit_4(0)), MASTER(pulse_of_bit_4(2))},
    {Rule::state_no_such_command, MASTER(first_word(0x0007)), MASTER(first_word(0x0006))},
    {Rule::state_not_awaited, MASTER(enabling_words(0)), MASTER(enabling_words(2))},
    {Rule::state_skips_states, MASTER(first_word(0x000F)), MASTER(first_word(0x0006))},
    {Rule::state_reset_without_edge, MASTER(reset_with_old_bit(true)), MASTER(reset_with_old_bit(false))},
    {Rule::state_reset_storm, MASTER(resets(6)), MASTER(resets(2))},
    {Rule::state_cause_not_read, MASTER(reset_after_reading(false)), MASTER(reset_after_reading(true))},
    {Rule::state_quick_stop_left, MASTER(leave_quick_stop(0x0006)), MASTER(leave_quick_stop(0x0000))},
    {Rule::state_transition_16, MASTER(leave_quick_stop(0x000F)), MASTER(leave_quick_stop(0x0000))},
    {Rule::state_power_off_in_motion, MASTER(power_off(false, false)), MASTER(power_off(true, true))},
    {Rule::state_gave_up, MASTER(enabling_that_gives_up(true)), MASTER(enabling_that_gives_up(false))},
    {Rule::state_reset_not_awaited, MASTER(enabling_after_reset(false)), MASTER(enabling_after_reset(true))},
    {Rule::state_reset_not_awaited, MASTER(second_reset(false)), MASTER(second_reset(true)), {"handshake-8"}},
    {Rule::mode_changed_in_motion, MASTER(mode_change(false)), MASTER(mode_change(true))},
    {Rule::mode_changed_in_motion, MASTER(mode_change_in_halt(true)), MASTER(mode_change_in_halt(false))},
    {Rule::mode_not_in_force, MASTER(edge_after_mode(false)), MASTER(edge_after_mode(true))},
    {Rule::mode_not_looked_at, MASTER(edge_without_display(false)), MASTER(edge_without_display(true))},
    {Rule::mode_written_again, MASTER(mode_again(3)), MASTER(mode_again(2))},
    {Rule::mode_foreign_target, MASTER(velocities_in_mode(kProfilePosition)), MASTER(velocities_in_mode(kProfileVelocity))},
    {Rule::homing_pulsed, MASTER(long_homing(20, false)), MASTER(long_homing(20, true))},
    {Rule::homing_given_up, MASTER(long_homing(3'000, false)), MASTER(long_homing(3'000, true))},
    {Rule::homing_start_kept, MASTER(second_homing(false)), MASTER(second_homing(true))},
    {Rule::homing_start_kept, MASTER(homing_with_bit_4_from_before(false)), MASTER(homing_with_bit_4_from_before(true))},
    {Rule::homing_judged_early, MASTER(homing_done_before(false)), MASTER(homing_done_before(true))},
    {Rule::motion_target_beyond_limits, MASTER(target_at_limit(12'000)), MASTER(target_at_limit(10'000))},
    {Rule::motion_speed_beyond_limit, MASTER(profile_speed(8'000)), MASTER(profile_speed(5'000))},
    {Rule::motion_step_too_long, MASTER(stream_with_jump()), MASTER(regular_stream())},
    {Rule::motion_step_too_long, MASTER(stream_at_motor_speed(12)), MASTER(stream_at_motor_speed(6))},
    {Rule::motion_acceleration_beyond_limit, MASTER(stream_with_acceleration(400'000)), MASTER(stream_with_acceleration(1'000'000))},
    {Rule::motion_set_point_repeated, MASTER(stream_with_repeat()), MASTER(regular_stream())},
    {Rule::motion_set_point_missing, MASTER(stream_with_gap()), MASTER(regular_stream())},
    {Rule::motion_first_target, MASTER(stream_from(5'000)), MASTER(stream_from(0))},
    {Rule::motion_following_error, MASTER(move_within_window(true)), MASTER(move_within_window(false))},
    {Rule::motion_torque_saturated, MASTER(move_with_blocked_load(true)), MASTER(move_with_blocked_load(false))},
    {Rule::motion_origin_moved, MASTER(stream_after_homing(false)), MASTER(stream_after_homing(true))},
    {Rule::motion_set_point_late, MASTER(late_set_point(true)), MASTER(late_set_point(false))},
    {Rule::writers_sdo_beside_pdo, MASTER(words_beside_pdo(Channel::sdo)), MASTER(words_beside_pdo(Channel::pdo))},
    {Rule::writers_two_sessions, MASTER(words_of({1, 2, 1})), MASTER(words_of({1, 2, 2}))},
    {Rule::pdo_not_operational, MASTER(pdo_in(NodeState::pre_operational)), MASTER(pdo_in(NodeState::operational))},
    {Rule::pdo_event_driven_stream, MASTER(synchronous_stream(255, 10, 1, true)), MASTER(synchronous_stream(1, 10, 1, true))},
    {Rule::pdo_two_in_a_cycle, MASTER(synchronous_stream(1, 10, 2, true)), MASTER(synchronous_stream(1, 10, 1, true))},
    {Rule::sync_period, MASTER(synchronous_stream(1, 1, 1, true)), MASTER(synchronous_stream(1, 10, 1, true))},
    {Rule::sync_absent, MASTER(synchronous_stream(1, 10, 1, false)), MASTER(synchronous_stream(255, 10, 1, false))},
    {Rule::sync_jitter, MASTER(synchronous_stream(1, 10, 1, true, false)), MASTER(synchronous_stream(1, 10, 1, true))},
    {Rule::supervision_goes_on_after_fault, MASTER(stream_through_fault(false)), MASTER(stream_through_fault(true))},
    {Rule::supervision_fall_unnoticed, MASTER(stream_through_fall(false)), MASTER(stream_through_fall(true))},
    {Rule::supervision_into_limit, MASTER(stream_into_limit(false)), MASTER(stream_into_limit(true))},
    {Rule::supervision_keep_alive, MASTER(signs_of_life(95)), MASTER(signs_of_life(50))},
    {Rule::supervision_store_often, MASTER(stores(30'000)), MASTER(stores(61'000))},
    {Rule::supervision_stop_cut_short, MASTER(power_off(true, false)), MASTER(power_off(true, true))},
    {Rule::supervision_left_enabled, MASTER(end_of_run(false)), MASTER(end_of_run(true))},
    {Rule::supervision_left_enabled, MASTER(nmt_stop(false)), MASTER(nmt_stop(true))},
  };
  return planted;
}

// clang-format on

#undef MASTER

}  // namespace

std::span<const Planted> planted_masters() {
  return rows();
}

}  // namespace vdrive::judge
