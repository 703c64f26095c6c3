// SPDX-License-Identifier: Apache-2.0
// The drives of deploy/axes/habits: each is loaded, enabled and moved.
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

namespace vdrive::bench {
namespace {

const std::filesystem::path kStrangers = VDRIVE_SOURCE_DIR "/deploy/axes/habits";
constexpr ObjectAddress kStrangersMode{0x6060, 0};
constexpr ObjectAddress kStrangersLoop{0x5E20, 6};

/// The axis of one of the files on a lock-step bench.
struct Stranger {
  Bench bench;
  client::Session session;
  client::Axis axis;

  explicit Stranger(const std::string& name)
      : bench({.configuration_file = kStrangers / name, .clock = ClockMode::lockstep}),
        session(bench.session()),
        axis(session.axis("1.1").value()) {}

  void expect_value(std::string_view object, std::int64_t value) const {
    const auto read = axis.read(describe(*find_object(object)).address);
    ASSERT_TRUE(read) << read.outcome().message();
    EXPECT_EQ(*read, value) << object;
  }

  /// @return a group of this axis only.
  client::AxisGroup group() {
    return client::AxisGroup::create(session, std::array<client::Axis, 1>{axis}).value();
  }

  /// @return the position of the load [UU].
  [[nodiscard]] std::int32_t position() const {
    return axis.status().value().status.load_position_actual_value;
  }

  void expect_moves_together(client::AxisGroup& axes, std::int32_t target) const {
    const client::Outcome moved = axes.move_together(Eigen::VectorXd::Constant(1, target));
    ASSERT_TRUE(moved) << moved.message();
    EXPECT_EQ(axis.status().value().status.position_demand_value, target);
  }

  void expect_moves() {
    for (const std::int32_t target : {2'000, -2'000}) {
      const client::Outcome moved = axis.move_to(target);
      ASSERT_TRUE(moved) << moved.message();
      EXPECT_EQ(axis.status().value().status.position_demand_value, target);
    }
  }
};

TEST(Strangers, AreTheThreeOfTheGuide) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kStrangers)) {
    names.insert(entry.path().filename().string());
    EXPECT_NO_THROW(check({.configuration_file = entry.path()})) << entry.path();
  }
  EXPECT_EQ(names, (std::set<std::string>{"old-servo.yaml", "slow-brake.yaml", "stepper.yaml"}));
}

TEST(Strangers, TheSlowBrakeIsWaitedFor) {
  Stranger slow("slow-brake.yaml");
  slow.expect_value("habit_power_on_time", 300);
  const std::uint64_t before = slow.axis.status().value().tick;
  const client::Outcome enabled = slow.axis.enable();
  ASSERT_TRUE(enabled) << enabled.message();
  EXPECT_GE(slow.axis.status().value().tick, before + 300);
  slow.expect_moves();
  // Without power it falls until its brake engages, for 30 ms with 0.6 N.m on 6e-4 kg.m2.
  ASSERT_TRUE(slow.axis.disturb(client::Disturbance::over_current));
  ASSERT_TRUE(slow.session.step(1, 100));
  const std::int32_t caught = slow.position();
  EXPECT_LT(caught, -2'100);
  ASSERT_TRUE(slow.session.step(1, 100));
  EXPECT_EQ(slow.position(), caught);
  ASSERT_TRUE(slow.axis.end_disturbances());
  slow.expect_value("habit_power_on_time", 300);
  const client::Outcome reset = slow.axis.reset_fault();
  ASSERT_TRUE(reset) << reset.message();
  EXPECT_TRUE(slow.axis.enable());
}

// Habit g and the release time of the model's brake add up. At rest the motor holds 0.6 N.m of its
// 3 N.m, up to 17 ‰ less or more because of its friction of 0.05 N.m.
TEST(Strangers, TheWeightOfTheSlowBrakeIsOnItsBrakeUntilThatIsOpen) {
  Stranger slow("slow-brake.yaml");
  ASSERT_TRUE(slow.session.step(1, 200));
  ASSERT_TRUE(slow.axis.enable());
  EXPECT_EQ(slow.position(), 0) << "the brake has held it";
  EXPECT_LT(slow.axis.status().value().status.torque_actual_value, 100);
  ASSERT_TRUE(slow.session.step(1, 3'000));
  EXPECT_NEAR(slow.axis.status().value().status.torque_actual_value, 200, 25);
  EXPECT_NEAR(slow.position(), 0, 3);
}

TEST(Strangers, TheStepperSeesEachEdge) {
  Stranger stepper("stepper.yaml");
  const client::Outcome enabled = stepper.axis.enable();
  ASSERT_TRUE(enabled) << enabled.message();
  stepper.expect_moves();
  const client::Outcome homed = stepper.axis.home({.method = 37, .call = {}});
  EXPECT_TRUE(homed) << homed.message();
}

TEST(Strangers, TheStepperFollowsAStreamFromItsFirstPositionOn) {
  Stranger stepper("stepper.yaml");
  auto group = stepper.group();
  ASSERT_TRUE(group.enable_all());
  const client::Outcome started = group.start_streaming();
  ASSERT_TRUE(started) << started.message();
  for (int tick = 1; tick <= 20; ++tick) {
    const auto shown = group.stream(Eigen::VectorXd::Constant(1, 10.0 * tick));
    ASSERT_TRUE(shown) << shown.outcome().message();
    ASSERT_TRUE(shown->not_following().empty()) << tick;
    ASSERT_EQ(shown->demand()[0], 10.0 * tick);
  }
  EXPECT_TRUE(group.stop_streaming());
}

// Controlwords 0006h, 0007h and 000Fh arrive in one tick, and the drive sees only the last.
TEST(Strangers, ADriveThatLooksOnceIn4MsIsEnabledWordByWordWhereItNeedsEach) {
  Stranger old("old-servo.yaml");
  ASSERT_TRUE(old.axis.write(kStrangersLoop, 4));
  const client::Outcome enabled = old.axis.enable();
  ASSERT_TRUE(enabled) << enabled.message();
  ASSERT_TRUE(old.axis.disable());
  auto group = old.group();
  const client::Outcome all = group.enable_all();
  ASSERT_TRUE(all) << all.message();
  EXPECT_EQ(old.axis.status().value().state(), PowerState::operation_enabled);
}

TEST(Strangers, TheOldServoNeedsItsModeBeforeItsPower) {
  Stranger old("old-servo.yaml");
  ASSERT_TRUE(old.axis.enable());
  const client::Outcome refused = old.axis.move_to(1'000);
  EXPECT_EQ(refused.code(), wire_code(AbortCode::refused_in_present_device_state));
  ASSERT_TRUE(old.axis.disable());
  ASSERT_TRUE(old.axis.write(kStrangersMode, 1));
  ASSERT_TRUE(old.axis.enable());
  old.expect_moves();
  EXPECT_TRUE(old.axis.quick_stop());
  EXPECT_TRUE(old.axis.enable());
  EXPECT_EQ(old.axis.status().value().status.ds402_statusword & 0xC000, 0x4000);
}

TEST(Strangers, AGroupOfTheOldServoNeedsItsModeBeforeItsPower) {
  Stranger old("old-servo.yaml");
  auto group = old.group();
  ASSERT_TRUE(group.enable_all());
  const client::Outcome refused = group.move_together(Eigen::VectorXd::Constant(1, 1'000.0));
  EXPECT_EQ(refused.code(), wire_code(AbortCode::refused_in_present_device_state));
  ASSERT_TRUE(group.disable_all());
  ASSERT_TRUE(old.axis.write(kStrangersMode, 1));
  ASSERT_TRUE(group.enable_all());
  for (const std::int32_t target : {2'000, -2'000}) old.expect_moves_together(group, target);
}

}  // namespace
}  // namespace vdrive::bench
