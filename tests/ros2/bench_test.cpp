// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

#include "fake_bench.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace vdrive::ros2 {
namespace {

TEST(Bench, HandsEachWishForControlOverOnceAndTheNewestOnly) {
  const FakeBench drives({"x"});
  Bench bench(drives.info(), drives.joints());
  EXPECT_EQ(bench.take_wishes().control, std::nullopt);
  bench.wish(ControlWish::give_back);
  bench.wish(ControlWish::take);
  EXPECT_EQ(bench.take_wishes().control, ControlWish::take) << "what was enabled since is kept";
  EXPECT_EQ(bench.take_wishes().control, std::nullopt);
}

TEST(Bench, ShowsWhichRequestItsLimitsAnswer) {
  const FakeBench drives({"x"});
  Bench bench(drives.info(), drives.joints());
  EXPECT_EQ(bench.seen().limits, nullptr);
  EXPECT_EQ(bench.request_limits(), 1U);
  const std::uint64_t request = bench.take_wishes().limits;
  EXPECT_EQ(bench.request_limits(), 2U) << "while they are read";
  bench.set_limits(std::make_shared<const std::vector<JointLimits>>(1), request);
  EXPECT_EQ(bench.seen().limits_read, 1U);
  EXPECT_EQ(bench.take_wishes().limits, 2U) << "the second request still waits";
}

TEST(Bench, HasTheRateOfItsClock) {
  FakeBench drives({"x"});
  drives.info().rate = 2.0;
  EXPECT_EQ(Bench(drives.info(), {}).seen().rate, 1.0) << "in lock-step no time passes alone";
  drives.info().clock_mode = ClockMode::realtime;
  EXPECT_EQ(Bench(drives.info(), {}).seen().rate, 2.0);
}

TEST(BenchCycle, ConvertsBetweenUserUnitsAndTheUnitsOfRos) {
  FakeBench drives({"x", "y"});
  Bench bench(drives.info(), drives.joints());
  drives.axis(1).status.position_demand_value = -1500;
  drives.axis(1).status.velocity_demand_value = 250;
  drives.link(bench);
  const BenchCycle now{.bench = bench, .seen = bench.seen()};
  const JointCycle joint = now.joint(1);
  EXPECT_EQ(joint.joint.label(), "joint y");
  EXPECT_DOUBLE_EQ(joint.demand().position, -1.5) << "a user unit is 0.001 rad";
  EXPECT_DOUBLE_EQ(joint.demand().velocity, 0.25);
  EXPECT_EQ(joint.user_units(-1.5), -1500);
  EXPECT_EQ(joint.user_units(0.0006), 1) << "rounded";
  EXPECT_DOUBLE_EQ(joint.seconds(1'010, 1'000), -0.01) << "also backwards";
}

}  // namespace
}  // namespace vdrive::ros2
