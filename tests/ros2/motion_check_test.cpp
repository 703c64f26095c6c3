// SPDX-License-Identifier: Apache-2.0
#include "motion_check.hpp"

#include "fake_bench.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::ros2 {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

std::string problem_with(CommandInterface interface, double value,
                         const JointLimits& limits = FakeBench::limits()) {
  return problem_of({.joint = {}, .interface = interface, .value = value},
                    FakeBench({"x"}).joints()[0], limits);
}

TEST(MotionCheck, NamesWhatKeepsTheBridgeFromAnAxis) {
  FakeBench bench({"x"});
  Bench::Names names;
  const auto obstacle = [&](bool has_limits = true) {
    return obstacle_of(bench.axis(0), FakeBench::kSession, has_limits, &names);
  };
  EXPECT_EQ(obstacle(), "is not under control of this bridge yet");
  bench.axis(0).owner_session = 0x0B;
  EXPECT_EQ(obstacle(), "is controlled by an unknown program, session 0x000000000000000b");
  names[0x0B] = {.program = "vdrive", .process = 4711, .host = "bench-host"};
  EXPECT_EQ(obstacle(),
            "is controlled by vdrive (process 4711 on bench-host), session 0x000000000000000b");
  bench.axis(0).owner_session = FakeBench::kSession;
  EXPECT_EQ(obstacle(false), "has limits that are not known yet");
  EXPECT_THAT(obstacle(), HasSubstr("Switch on disabled"));
  bench.enable();
  EXPECT_THAT(obstacle(), IsEmpty());
}

TEST(MotionCheck, PermitsAValueAtItsLimitAndNoneBeyond) {
  EXPECT_THAT(problem_with(CommandInterface::position, 10.0), IsEmpty());
  EXPECT_EQ(problem_with(CommandInterface::position, 10.5),
            "position 10.5 rad is beyond the limits -10 to 10");
  EXPECT_EQ(problem_with(CommandInterface::position, -10.5),
            "position -10.5 rad is beyond the limits -10 to 10");
  EXPECT_THAT(problem_with(CommandInterface::velocity, -5.0), IsEmpty());
  EXPECT_EQ(problem_with(CommandInterface::velocity, -5.5), "velocity -5.5 is above the limit 5");
  EXPECT_THAT(problem_with(CommandInterface::effort, 3.0), IsEmpty());
  EXPECT_EQ(problem_with(CommandInterface::effort, 3.5), "effort 3.5 is above the limit 3");
}

TEST(MotionCheck, RefusesAPositionThatNoSpeedOrRampReaches) {
  JointLimits still = FakeBench::limits();
  still.ramp = 0.0;
  EXPECT_THAT(problem_with(CommandInterface::position, 1.0, still), HasSubstr("allows no motion"));
  still = FakeBench::limits();
  still.velocity = 0.0;
  EXPECT_THAT(problem_with(CommandInterface::position, 1.0, still), HasSubstr("allows no motion"));
}

}  // namespace
}  // namespace vdrive::ros2
