// SPDX-License-Identifier: Apache-2.0
// Sequences of the set-point model, printed and run by the tool on a bench in lock-step, give the
// same statuswords in the same ticks as in the core.
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

Finished run_printed(const std::string& text) {
  return Process(VDRIVE_TOOL,
                 {"run", "--private", "--config", VDRIVE_SOURCE_DIR "/tests/data/whole_units.yaml",
                  "-"},
                 text)
      .wait();
}

class PrintedSequence : public testing::TestWithParam<std::uint64_t> {
 protected:
  const std::vector<Step> steps = fixed_sequence(GetParam(), 30);
  const SideBySide run = run_side_by_side(steps);
};

TEST_P(PrintedSequence, GivesTheSameStatuswordsTickByTickInABench) {
  ASSERT_EQ(run.difference, "");
  const std::string text = scenario_of(steps, run.ticks);
  const Finished finished = run_printed(text);
  EXPECT_EQ(finished.code, 0) << finished.errors << text;
}

TEST(PrintedScenario, FailsWhereAStatuswordOfTheModelIsWrong) {
  const std::vector<Step> steps = fixed_sequence(1, 10);
  SideBySide run = run_side_by_side(steps);
  run.ticks.back().statusword ^= 0x0400U;
  const Finished finished = run_printed(scenario_of(steps, run.ticks));
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, testing::HasSubstr("0x6041"));
}

INSTANTIATE_TEST_SUITE_P(PrintedScenario, PrintedSequence, testing::Values(1, 2, 3, 4),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace vdrive::test
