// SPDX-License-Identifier: Apache-2.0
// The shutdown of a bench: which commands are refused, how the axes stop.
#include "service/engine_under_test.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace vdrive::test {
namespace {

using service::Braking;

constexpr std::int64_t kEnable = 0x0F;
constexpr std::int64_t kNewSetPoint = 0x1F;
constexpr std::int64_t kSwitchOnDisabled = 0x40;  // masked with 4Fh
constexpr std::int64_t kOperationEnabled = 0x27;  // masked with 6Fh

service::Configuration passing_time(std::size_t axes = 3) {
  auto configuration = bench_configuration(axes);
  configuration.clock = service::ClockMode::freerun;
  return configuration;
}

struct EndingBench : EngineUnderTest {
  explicit EndingBench(const service::Configuration& with = passing_time())
      : EngineUnderTest(with) {}

  std::int64_t speed(std::uint16_t axis) { return value(axis, 0x606B); }

  bool is_switch_on_disabled(std::uint16_t axis) {
    return (value(axis, 0x6041) & 0x4F) == kSwitchOnDisabled;
  }

  /// Moves the axis at 40 000 UU/s. Its ramp of 80 000 UU/s2 would stop it in 0.5 s, by 80 UU/s a
  /// tick.
  void run_fast(std::uint16_t axis) {
    write(kAlice, axis, 0x6081, 40'000);
    write(kAlice, axis, 0x6083, 4'000'000);
    write(kAlice, axis, 0x6084, 80'000);
    write(kAlice, axis, 0x6060, 1);
    write(kAlice, axis, 0x607A, 1'000'000'000);
    write(kAlice, axis, 0x6040, kEnable);
    steps(2);
    write(kAlice, axis, 0x6040, kNewSetPoint);
    steps(60);
    ASSERT_EQ(speed(axis), 40'000);
  }
};

TEST(EngineShutdown, BrakesAMovingAxisOnItsRampThenSwitchesItOff) {
  EndingBench bench;
  bench.run_fast(1);
  bench.engine.shut_down(Braking::ramp);
  bench.steps(250);
  // 250 ticks of 1 ms at 80 000 UU/s2 slow the axis by 20 000 UU/s; the tick in which the ramp
  // begins may count as well.
  EXPECT_NEAR(static_cast<double>(bench.speed(1)), 20'000.0, 160.0);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, kOperationEnabled);
  EXPECT_TRUE(bench.engine.has_power());
  bench.steps(350);
  EXPECT_TRUE(bench.is_switch_on_disabled(1));
  EXPECT_FALSE(bench.engine.has_power());
}

TEST(EngineShutdown, FollowsTheOptionCodeOfDisableOperation) {
  EndingBench bench;
  bench.run_fast(1);
  bench.write(kAlice, 1, 0x605C, 0);  // no ramp
  bench.engine.shut_down(Braking::ramp);
  bench.steps(2);
  EXPECT_TRUE(bench.is_switch_on_disabled(1));
}

TEST(EngineShutdown, BrakesHarderAfterASecondRequest) {
  EndingBench bench;
  bench.run_fast(1);
  bench.write(kAlice, 1, 0x6085, 4'000'000);  // 40 000 UU/s in 10 ms
  bench.engine.shut_down(Braking::ramp);
  bench.steps(10);
  bench.engine.shut_down(Braking::quick_stop);
  bench.steps(8);
  EXPECT_LT(bench.speed(1), 10'000) << "4 000 UU/s less in each tick";
  bench.steps(200);
  EXPECT_TRUE(bench.is_switch_on_disabled(1));
}

TEST(EngineShutdown, WaitsForAQuickStopInProgress) {
  EndingBench bench;
  bench.run_fast(1);
  bench.write(kAlice, 1, 0x605A, 6);  // remains in Quick stop active
  bench.write(kAlice, 1, 0x6085, 400'000);
  bench.write(kAlice, 1, 0x6040, 0x02);
  bench.steps(20);
  bench.engine.shut_down(Braking::ramp);
  bench.steps(20);
  EXPECT_GT(bench.speed(1), 0) << "100 ms from 40 000 UU/s";
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x07) << "Quick stop active";
  bench.steps(200);
  EXPECT_TRUE(bench.is_switch_on_disabled(1));
}

TEST(EngineShutdown, RemovesThePowerAtOnceWithoutTimeToBrake) {
  EndingBench bench(bench_configuration(3));
  bench.run_fast(1);
  bench.engine.shut_down(Braking::none);
  EXPECT_FALSE(bench.engine.has_power());
  bench.steps(1);
  EXPECT_TRUE(bench.is_switch_on_disabled(1));
  EXPECT_EQ(bench.value(1, 0x3005), 0) << "no power";
}

TEST(EngineShutdown, DoesNotChangeFaultsAndAxesWithoutPower) {
  EndingBench bench;
  bench.write(kAlice, 1, 0x5E02, 1);  // over-current
  bench.write(kAlice, 3, 0x6040, 0x06);
  bench.steps(2);
  const auto before = bench.value(2, 0x6041);
  bench.engine.shut_down(Braking::ramp);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x4F, 0x08) << "Fault";
  EXPECT_EQ(bench.value(2, 0x6041), before);
  EXPECT_TRUE(bench.is_switch_on_disabled(3)) << "was Ready to switch on";
}

TEST(EngineShutdown, AnswersReadsOnly) {
  EndingBench bench;
  bench.acquire(kAlice, {1});
  bench.engine.shut_down(Braking::ramp);
  EXPECT_EQ(bench.write(kAlice, 1, 0x6040, kEnable).reason, msg::Reason::shutting_down);
  EXPECT_EQ(bench.write(kAlice, 2, 0x5E02, 1).reason, msg::Reason::shutting_down);
  EXPECT_EQ(bench.acquire(kBob, {2}).reason, msg::Reason::shutting_down);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::power_cycle, kAlice, {1})).reason,
            msg::Reason::shutting_down);
  EXPECT_EQ(bench.read(1, 0x6041).reason, msg::Reason::none);
  auto frame = bench.make_frame(kAlice);
  set_controlword(add_command(frame, 1), kEnable);
  bench.receive(frame);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::shutting_down);
  bench.steps(2);
  EXPECT_NE(bench.value(1, 0x6041) & 0x6F, kOperationEnabled);
}

TEST(EngineShutdown, IgnoresAKeepAlive) {
  EndingBench bench;
  bench.acquire(kAlice, {1});
  auto frame = bench.make_frame(kAlice);
  frame.flags = 0;
  bench.engine.shut_down(Braking::ramp);
  bench.receive(frame);
  EXPECT_FALSE(bench.command_reply());
  EXPECT_TRUE(bench.events(msg::EventKind::refused).empty());
}

TEST(EngineShutdown, SendsOneEventAndDropsPendingFrames) {
  EndingBench bench;
  bench.acquire(kAlice, {1});
  auto frame = bench.make_frame(kAlice);
  set_controlword(add_command(frame, 1), kEnable);
  frame.apply_at_tick = bench.engine.tick() + 5;
  bench.receive(frame);
  bench.engine.shut_down(Braking::ramp);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::cancelled);
  bench.engine.shut_down(Braking::quick_stop);
  EXPECT_EQ(bench.events(msg::EventKind::shutdown).size(), 1U);
  bench.steps(10);
  EXPECT_TRUE(bench.is_switch_on_disabled(1));
}

TEST(EngineShutdown, TurnsTheWatchdogOff) {
  EndingBench bench;
  bench.acquire(kAlice, {1});
  bench.run_fast(1);
  bench.engine.shut_down(Braking::ramp);
  bench.steps(600);  // the watchdog would act after 100
  EXPECT_EQ(bench.counters.master_losses.get(), 0U);
  EXPECT_TRUE(bench.is_switch_on_disabled(1)) << "and not in Fault";
}

}  // namespace
}  // namespace vdrive::test
