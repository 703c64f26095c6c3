// SPDX-License-Identifier: Apache-2.0
// `vdrive bench`: private benches over DDS, all of which end.
#include "tool/json_lines.hpp"
#include "tool/marked_calls.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

namespace vdrive::test {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

class Measurement : public MarkedCalls {};

TEST_F(Measurement, FindsTheCapacityOfTheMachine) {
  const Finished finished = start("bench", {"--quick", "--json"}).wait();
  ASSERT_EQ(finished.code, 0) << finished.errors;
  ASSERT_THAT(finished.lines(), SizeIs(1));
  const Json figures = Json::parse(finished.lines()[0]);
  // A second has 1,000 ticks; on a busy machine it has fewer, all of them late.
  EXPECT_GT(figures["lateness_of_ticks"]["max_us"], 0.0);
  EXPECT_GT(figures["lateness_of_a_bare_loop"]["max_us"], 0.0);
  EXPECT_GT(figures["steps"]["per_second"], 10.0);
  // Stepping an axis takes more than 1 ns on any processor, and less than 1 ms on any machine.
  EXPECT_GT(figures["tick_of_an_axis_ns"], 1.0);
  EXPECT_LT(figures["tick_of_an_axis_ns"], 1.0e6);
  EXPECT_EQ(figures["status"][0]["axes"], 64);
  EXPECT_GT(figures["status"][0]["samples"], 0);
  EXPECT_TRUE(all_have_ended());
}

TEST_F(Measurement, NeedsAService) {
  const Finished finished = start("bench", {"--service", "/nonexistent"}).wait();
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors, HasSubstr("/nonexistent"));
}

class MeasurementEndedBy : public MarkedCalls, public testing::WithParamInterface<int> {};

TEST_P(MeasurementEndedBy, ASignalLeavesNoProcessBehind) {
  Process bench = start("bench", {});
  ASSERT_TRUE(wait_for_process({"vdrived", "--axes"}));
  bench.send(GetParam());
  EXPECT_EQ(bench.wait().code, GetParam() == SIGKILL ? -SIGKILL : 130);
  EXPECT_TRUE(all_have_ended());
}

INSTANTIATE_TEST_SUITE_P(Signals, MeasurementEndedBy, testing::Values(SIGINT, SIGTERM, SIGKILL));

}  // namespace
}  // namespace vdrive::test
