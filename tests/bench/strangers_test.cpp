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

/// The axis of the bench of one of the files, in lock-step.
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
  ASSERT_TRUE(slow.axis.disturb(client::Disturbance::over_current));
  ASSERT_TRUE(slow.session.step(1, 100));
  ASSERT_TRUE(slow.axis.end_disturbances());
  slow.expect_value("habit_power_on_time", 300);
  const client::Outcome reset = slow.axis.reset_fault();
  ASSERT_TRUE(reset) << reset.message();
  EXPECT_TRUE(slow.axis.enable());
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
  auto group =
      client::AxisGroup::create(stepper.session, std::array<client::Axis, 1>{stepper.axis}).value();
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

// The words 0006h, 0007h and 000Fh come in one tick, of which it sees the last one.
TEST(Strangers, ADriveThatLooksOnceIn4MsIsEnabledWordByWordWhereItNeedsEach) {
  Stranger old("old-servo.yaml");
  ASSERT_TRUE(old.axis.write(kStrangersLoop, 4));
  const client::Outcome enabled = old.axis.enable();
  ASSERT_TRUE(enabled) << enabled.message();
  ASSERT_TRUE(old.axis.disable());
  auto group =
      client::AxisGroup::create(old.session, std::array<client::Axis, 1>{old.axis}).value();
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

}  // namespace
}  // namespace vdrive::bench
