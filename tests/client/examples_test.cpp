// SPDX-License-Identifier: Apache-2.0
// The example programs, unmodified, with real services.
#include "client/session_options.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::Finished;
using test::patient;
using test::RunningService;
using testing::HasSubstr;

Finished run(const std::string& example) {
  return test::Process(std::string(VDRIVE_EXAMPLES "/").append(example),
                       {std::to_string(test::test_domain())})
      .wait();
}

/// @return 6064h of an axis.
std::int64_t position(const std::string& axis) {
  SessionOptions options;
  options.domain = test::test_domain();
  options.find_timeout = 20s;
  Session session(options);
  return session.axis(axis)->status()->status.load_position_actual_value;
}

TEST(Examples, TheProgramOfTheReadme) {
  const RunningService service(patient("--clock realtime --axes 1"));
  setenv("VDRIVE_DOMAIN", std::to_string(test::test_domain()).c_str(), 1);  // NOLINT(*-mt-unsafe)
  const Finished ended = run("readme");
  EXPECT_EQ(ended.code, 0) << ended.output << ended.errors;
  EXPECT_EQ(ended.output, "at 10000\n");
  EXPECT_EQ(position("1.1"), 10'000);
}

TEST(Examples, EnableAndMove) {
  const RunningService service(patient("--clock realtime --axes 2"));
  const Finished ended = run("01_enable_and_move");
  EXPECT_EQ(ended.code, 0) << ended.errors;
  EXPECT_THAT(ended.output, HasSubstr("asked for -5000, is at -5000"));
  EXPECT_EQ(position("1.1"), 2048);
}

TEST(Examples, ThreeAxisFigure) {
  const RunningService service("--clock lockstep --axes 3");
  const Finished ended = run("02_three_axis_figure");
  EXPECT_EQ(ended.code, 0) << ended.output << ended.errors;
  EXPECT_THAT(ended.output, HasSubstr("corner 8"));
  for (const char* const axis : {"1.1", "1.2", "1.3"}) EXPECT_EQ(position(axis), 0) << axis;
}

/// Runs the example of two services. @return whether the machine kept up. It did not if a bench
/// reports that it skipped ticks, because the axes are then no longer in step, or if a late frame
/// ended the example.
bool draw_gantry() {
  RunningService left(patient("--clock realtime --axes 1 --log-level debug"));
  RunningService right(patient("--clock realtime --bench 2 --axes 1 --log-level debug"));
  const Finished ended = run("03_two_services_one_group");
  if (ended.code != 0 && (ended.output + ended.errors).find("too late") != std::string::npos) {
    return false;
  }
  EXPECT_EQ(ended.code, 0) << ended.output << ended.errors;
  EXPECT_EQ(position("1.1"), 1000);
  EXPECT_EQ(position("2.1"), 1000);
  const std::string logs = left.stop().errors + right.stop().errors;
  if (logs.find("tick number jumped") != std::string::npos) return false;
  EXPECT_THAT(ended.output, HasSubstr("largest skew of the demands: 0 UU"));
  return true;
}

TEST(Examples, TwoServicesOneGroup) {
  bool kept_up = false;
  for (int attempt = 0; attempt < 5 && !kept_up; ++attempt) kept_up = draw_gantry();
  EXPECT_TRUE(kept_up) << "a bench had to skip ticks, five times of five";
}

TEST(Examples, Cosimulation) {
  const RunningService service("--clock lockstep");
  const Finished ended = run("04_cosimulation");
  EXPECT_EQ(ended.code, 0) << ended.output << ended.errors;
  // 0.5 kg at 0.2 m: 9.81 m/s² · 0.1 kg.m = 981 mN.m; upright the torque is zero.
  EXPECT_THAT(ended.output, HasSubstr("against -981 mN.m"));
  EXPECT_THAT(ended.output, HasSubstr("against 0 mN.m"));
  EXPECT_NEAR(static_cast<double>(position("1.1")), 2048.0, 1.0);
}

TEST(Examples, TestBenchWithFaults) {
  const RunningService service("--clock lockstep");
  const Finished ended = run("05_test_bench_with_faults");
  EXPECT_EQ(ended.code, 0) << ended.output << ended.errors;
  EXPECT_THAT(ended.output, HasSubstr("5 faults survived"));
  EXPECT_THAT(ended.output, HasSubstr("0x2310"));
  EXPECT_THAT(ended.output, HasSubstr("too early"));
  EXPECT_EQ(position("1.1"), 0);
}

// From 0 to 4096 UU; each set-point is the demand in the tick for which it was sent.
TEST(Examples, SetPoints) {
  const RunningService service("--clock lockstep");
  const Finished ended = run("07_set_points");
  EXPECT_EQ(ended.code, 0) << ended.output << ended.errors;
  EXPECT_EQ(ended.output, "2000 set-points, 0 not followed, at 4096\n");
  EXPECT_EQ(position("1.1"), 4096);
}

}  // namespace
}  // namespace vdrive::client
