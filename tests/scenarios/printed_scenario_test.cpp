// SPDX-License-Identifier: Apache-2.0
// Sequences of the set-point model, printed and run against a service in lock-step: the same
// statuswords in the same ticks as in the core.
#include "core/support/set_point_model.hpp"
#include "core/support/set_point_sequences.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

const std::string kBench =
    "--clock lockstep --config " VDRIVE_SOURCE_DIR "/tests/data/whole_units.yaml";

class PrintedSequence : public testing::TestWithParam<std::uint64_t> {
 protected:
  const std::vector<Step> steps = fixed_sequence(GetParam(), 30);
  const SideBySide run = run_side_by_side(steps);
};

TEST_P(PrintedSequence, GivesTheSameStatuswordsTickByTickInAService) {
  ASSERT_EQ(run.difference, "");
  const RunningService service(kBench);
  const std::string text = scenario_of(steps, run.ticks);
  const Finished finished = tool("run -", text);
  EXPECT_EQ(finished.code, 0) << finished.errors << text;
}

TEST(PrintedScenario, FailsWhereAStatuswordOfTheModelIsWrong) {
  const std::vector<Step> steps = fixed_sequence(1, 10);
  SideBySide run = run_side_by_side(steps);
  run.ticks.back().statusword ^= 0x0400U;
  const RunningService service(kBench);
  const Finished finished = tool("run -", scenario_of(steps, run.ticks));
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, testing::HasSubstr("0x6041"));
}

INSTANTIATE_TEST_SUITE_P(PrintedScenario, PrintedSequence, testing::Values(1, 2, 3, 4),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace vdrive::test
