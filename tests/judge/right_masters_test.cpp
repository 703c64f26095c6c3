// SPDX-License-Identifier: Apache-2.0
// Masters that keep every rule, with random distances, times, limits and drives: no finding at all.
#include "judge/axis_track.hpp"
#include "judge/judged_drive.hpp"
#include "support/random_cases.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdrive::judge {
namespace {

using test::Random;
using testing::IsEmpty;

/// 1,000 seeds, more in nightly runs, fewer in ordinary ones.
std::uint64_t last_seed() {
  return test::number_of<std::uint64_t>({.usual = 150, .full = 1'000, .nightly = 10'000});
}

/// A source that shows the drive every 1 to 10 ticks, with some habits of other drives.
TestSource draw_source(Random& random) {
  TestSource source;
  source.ticks_a_status = static_cast<std::uint64_t>(random.between(1, 10));
  return source;
}

void draw_habits(JudgedDrive& drive, Random& random) {
  if (random.per_mille(300)) drive.disturb({0x5E20, 7}, random.between(0, 300));  // power on
  if (random.per_mille(300)) drive.disturb({0x5E20, 8}, random.between(0, 100));  // mode display
  if (random.per_mille(300)) drive.disturb({0x5E20, 9}, random.between(0, 100));  // reset
  // If a drive samples its controlwords once per loop and also has bit 12 set from enabling on,
  // nobody can know when it has seen an edge.
  if (random.per_mille(500)) {
    drive.disturb({0x5E20, 6}, random.between(0, 4));  // loop of controlwords
  } else if (random.per_mille(400)) {
    drive.disturb({0x5E20, 1}, 1);  // bit 12 set from enabling on
  }
  if (random.per_mille(200)) drive.disturb({0x5E20, 0x0C}, random.between(0, 1) * 0xC000);
}

/// Reads the limits that the master knows from then on.
void read_limits(JudgedDrive& drive) {
  for (const ObjectAddress object :
       {objects::kFollowingWindow, objects::kMaxTorque, objects::kSpeedLimit, objects::kLowerLimit,
        objects::kUpperLimit, objects::kShutdownOption, objects::kErrorCode}) {
    drive.read(object);
  }
}

void stay(JudgedDrive& drive, Random& random, std::int64_t longest) {
  drive.step(static_cast<std::uint64_t>(random.between(0, longest)));
}

std::int32_t draw_target(Random& random) {
  return static_cast<std::int32_t>(random.between(-20'000, 20'000));
}

void wait_for_mode(JudgedDrive& drive, std::int8_t mode) {
  drive.step_until([&] {
    return drive.status().op_mode_actual == mode;
  });
}

void change_mode(JudgedDrive& drive, std::int8_t mode) {
  if (drive.status().op_mode_actual == mode) return;
  drive.mode(mode);
  wait_for_mode(drive, mode);
}

void wait_until_at_rest(JudgedDrive& drive) {
  std::int32_t before = drive.position();
  drive.step_until([&] {
    const bool rests = std::abs(drive.position() - before) <= 1;
    before = drive.position();
    return rests && std::abs(drive.status().load_velocity_actual_value) < 20;
  });
}

void recover(JudgedDrive& drive, Random& random, std::int8_t mode) {
  drive.disturb({0x5E02, 0}, 1);
  drive.step_until_state(PowerState::fault);
  drive.disturb({0x5E02, 0}, 0);
  stay(drive, random, 300);
  drive.read(objects::kErrorCode);
  drive.word(0x0000);
  stay(drive, random, 5);
  drive.step_until_state(PowerState::fault);
  drive.word(Controlword::kFaultReset);
  drive.step_until_state(PowerState::switch_on_disabled);
  drive.word(0x0000);
  stay(drive, random, 20);
  drive.step(12);
  drive.enable(mode);
}

// ---- the masters -------------------------------------------------------------------------------

void halt_and_resume(JudgedDrive& drive, Random& random) {
  drive.set_point(draw_target(random));
  stay(drive, random, 100);
  drive.word(kEnabled | Controlword::kHalt);
  drive.step_until_bits(kReached, kReached);
  drive.word(kEnabled);
  drive.step_until_bits(kReached, kReached);
}

void stop_quickly(JudgedDrive& drive, Random& random) {
  drive.set_point(draw_target(random));
  stay(drive, random, 100);
  drive.word(controlwords::kQuickStop);
  drive.step_until_state(PowerState::switch_on_disabled);
  drive.step(12);
  drive.enable(kProfilePosition);
}

void run_handshake(JudgedDrive& drive, Random& random) {
  drive.enable(kProfilePosition);
  const int moves = static_cast<int>(random.between(1, 4));
  for (int i = 0; i < moves; ++i) {
    const std::uint16_t bits =
        (random.per_mille(500) ? Controlword::kChangeSetImmediately : std::uint16_t{0}) |
        (random.per_mille(300) ? Controlword::kRelative : std::uint16_t{0});
    switch (random.below(6)) {
      case 0:
        drive.set_point(draw_target(random), bits);  // the next one follows immediately
        break;
      case 1:
        halt_and_resume(drive, random);
        break;
      case 2:
        stop_quickly(drive, random);
        break;
      case 3:
        recover(drive, random, kProfilePosition);
        break;
      default:
        drive.move(draw_target(random), bits);
    }
    stay(drive, random, 30);
  }
  drive.step_until_bits(kReached, kReached);
  drive.disable();
}

/// A quintic polynomial, as stream generators plan it: speed and acceleration are 0 at both ends.
void stream_to(JudgedDrive& drive, std::int32_t to, int cycles, std::uint64_t ticks,
               Channel channel) {
  const std::int32_t from = drive.status().position_demand_value;
  for (int i = 1; i <= cycles; ++i) {
    const double s = static_cast<double>(i) / cycles;
    const double way = s * s * s * (10 + s * (6 * s - 15));
    drive.target(static_cast<std::int32_t>(std::lround(from + (to - from) * way)), channel);
    drive.step(ticks);
  }
}

void run_stream(JudgedDrive& drive, Random& random) {
  drive.mode(kCyclicPosition);
  wait_for_mode(drive, kCyclicPosition);
  drive.target(drive.position());
  drive.enable(kCyclicPosition);
  const int moves = static_cast<int>(random.between(1, 3));
  for (int i = 0; i < moves; ++i) {
    const auto way = static_cast<std::int32_t>(random.between(-5'000, 5'000));
    stream_to(drive, drive.status().position_demand_value + way,
              static_cast<int>(random.between(200, 600)), 1, Channel::frame);
    stay(drive, random, 30);
  }
  wait_until_at_rest(drive);
  drive.disable();
}

void run_homing(JudgedDrive& drive, Random& random) {
  constexpr std::array<std::int64_t, 4> kMethods{17, 18, 35, 37};
  const std::int64_t method = kMethods.at(random.below(kMethods.size()));
  drive.write({0x6098, 0}, method);
  drive.write({0x607C, 0}, random.between(-5'000, 5'000));
  drive.write({0x6099, 1}, 20'000);
  drive.write({0x6099, 2}, 5'000);
  if (random.per_mille(500)) {
    drive.enable(kProfilePosition);
    drive.move(draw_target(random));
    change_mode(drive, kHoming);
  } else {
    drive.enable(kHoming);
  }
  // The switch is at a position that the axis reaches after a while.
  const std::int32_t begin = drive.position();
  drive.word(kSetPoint);
  const ObjectAddress input{static_cast<std::uint16_t>(method == 17 ? 0x5E07 : 0x5E06), 0};
  bool is_active = false;
  drive.step_until([&] {
    const bool is_there = method < 20 && std::abs(drive.position() - begin) > 3'000 &&
                          (method == 17) == (drive.position() < begin);
    if (is_there != is_active && !drive.shows(kAttained)) {
      drive.disturb(input, is_there ? 1 : 0);
      is_active = is_there;
    }
    return drive.shows(kAttained | kReached);
  });
  drive.word(kEnabled);
  stay(drive, random, 20);
  if (is_active) drive.disturb(input, 0);
  drive.step(12);
  const std::int8_t next = random.per_mille(500) ? kProfilePosition : kCyclicPosition;
  if (next == kCyclicPosition) drive.target(drive.position());
  change_mode(drive, next);
  if (next == kCyclicPosition) {
    stream_to(drive, drive.position() + 2'000, 300, 1, Channel::frame);
  } else {
    drive.move(draw_target(random));
  }
  wait_until_at_rest(drive);
  drive.disable();
}

void run_velocity(JudgedDrive& drive, Random& random) {
  drive.write(objects::kTargetVelocity, 0);
  drive.enable(kProfileVelocity);
  const int speeds = static_cast<int>(random.between(1, 8));
  for (int i = 0; i < speeds; ++i) {
    drive.write(objects::kTargetVelocity, random.between(-30'000, 30'000));
    stay(drive, random, 200);
  }
  drive.write(objects::kTargetVelocity, 0);
  drive.step_until_bits(Statusword::kSpeedZero, Statusword::kSpeedZero);
  wait_until_at_rest(drive);
  drive.disable();
}

/// Mode 8 by synchronous PDOs, as a CANopen master does it: 6040h and 607Ah in each cycle.
void run_synchronous(JudgedDrive& drive, Random& random) {
  const auto cycle = static_cast<std::uint64_t>(random.between(2, 12));
  const auto cycle_units = static_cast<std::int64_t>(cycle);
  drive.take(Network{.state = NodeState::pre_operational});
  drive.write(objects::kCyclePeriod, cycle_units, Channel::sdo);
  drive.write(objects::kCycleIndex, -3, Channel::sdo);
  drive.write(objects::kMode, kCyclicPosition, Channel::sdo);
  wait_for_mode(drive, kCyclicPosition);
  drive.take(Network{.state = NodeState::operational, .is_command = true});
  std::int32_t demand = drive.position();
  std::uint16_t word = controlwords::kShutdown;
  const auto turn = [&] {
    drive.take(Sync{});
    drive.take(ReceivePdo{.number = 1, .type = std::uint8_t{1}});
    drive.target(demand, Channel::pdo);
    drive.word(word, Channel::pdo);
    drive.step(cycle);
  };
  const auto reach = [&](std::uint16_t next, PowerState state) {
    word = next;
    for (int i = 0; i < 1'000 && decode_power_state(drive.statusword()) != state; ++i) turn();
  };
  reach(controlwords::kShutdown, PowerState::ready_to_switch_on);
  reach(controlwords::kSwitchOn, PowerState::switched_on);
  reach(kEnabled, PowerState::operation_enabled);
  const std::int32_t from = demand;
  const auto way = static_cast<double>(random.between(-10'000, 10'000));
  const int cycles = static_cast<int>(random.between(100, 200));
  for (int i = 1; i <= cycles; ++i) {
    const double s = static_cast<double>(i) / cycles;
    demand =
        static_cast<std::int32_t>(std::lround(from + way * s * s * s * (10 + s * (6 * s - 15))));
    turn();
  }
  for (int i = 0; i < 60; ++i) turn();
  reach(controlwords::kShutdown, PowerState::ready_to_switch_on);
  drive.take(Network{.state = NodeState::pre_operational, .is_command = true});
}

using Master = void (*)(JudgedDrive& drive, Random& random);

/// @return the findings, for a message.
std::vector<std::string> told(const Verdict& verdict) {
  std::vector<std::string> texts;
  for (const Finding& finding : verdict.findings) {
    texts.push_back(std::string(row_of(finding.rule).name) + " at tick " +
                    std::to_string(finding.first.tick) + ": " + finding.happened);
  }
  return texts;
}

void expect_no_finding(Master master, bool has_habits) {
  for (std::uint64_t seed = 1; seed <= last_seed(); ++seed) {
    Random random(seed);
    JudgedDrive drive(draw_source(random));
    if (has_habits) draw_habits(drive, random);
    read_limits(drive);
    master(drive, random);
    EXPECT_THAT(told(drive.end(true)), IsEmpty()) << "seed " << seed;
  }
}

TEST(RightMasters, OfProfilePositionGetNoFinding) {
  expect_no_finding(run_handshake, true);
}

TEST(RightMasters, OfStreamsGetNoFinding) {
  expect_no_finding(run_stream, true);
}

TEST(RightMasters, OfHomingGetNoFinding) {
  expect_no_finding(run_homing, true);
}

TEST(RightMasters, OfVelocityGetNoFinding) {
  expect_no_finding(run_velocity, true);
}

TEST(RightMasters, OfSynchronousPdosGetNoFinding) {
  expect_no_finding(run_synchronous, true);
}

// The axes of a group share one judge and act one after the other in each tick.
TEST(RightMasters, OfGroupsGetNoFinding) {
  for (std::uint64_t seed = 1; seed <= last_seed(); ++seed) {
    Random random(seed);
    const TestSource source = draw_source(random);
    Judge judge(source.facts);
    std::vector<std::unique_ptr<JudgedDrive>> axes;
    for (std::uint32_t number = 1; number <= 3; ++number) {
      axes.push_back(std::make_unique<JudgedDrive>(judge, source, AxisConfiguration{}, number));
      read_limits(*axes.back());
      axes.back()->enable(kProfilePosition);
    }
    const int moves = static_cast<int>(random.between(1, 3));
    for (int i = 0; i < moves; ++i) {
      for (const auto& axis : axes) axis->target(draw_target(random));
      for (const auto& axis : axes) axis->word(kSetPoint);
      for (const auto& axis : axes) {
        axis->step_until_bits(Statusword::kSetPointAcknowledge, Statusword::kSetPointAcknowledge);
      }
      for (const auto& axis : axes) axis->word(kEnabled);
      for (const auto& axis : axes) axis->step_until_bits(kReached, kReached);
    }
    for (const auto& axis : axes) axis->disable();
    EXPECT_THAT(told(judge.end(true)), IsEmpty()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace vdrive::judge
