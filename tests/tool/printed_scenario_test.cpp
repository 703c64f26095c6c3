// SPDX-License-Identifier: Apache-2.0
// The failing sequence that the set-point model prints is a scenario of the tool, line by line.
#include "command_table.hpp"
#include "core/support/set_point_model.hpp"
#include "core/support/set_point_sequences.hpp"
#include "language/scenario.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

std::size_t count_writes(const std::vector<test::Step>& steps) {
  std::size_t writes = 0;
  for (const test::Step& step : steps) writes += step.writes.size();
  return writes;
}

TEST(PrintedScenario, IsAcceptedByTheParserOfVdriveRun) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const std::vector<test::Step> steps = test::fixed_sequence(seed, 20);
    const test::SideBySide run = test::run_side_by_side(steps);
    ASSERT_EQ(run.difference, "");
    std::istringstream text(test::scenario_of(steps, run.ticks));
    Scenario scenario;
    ASSERT_NO_THROW(scenario = parse_scenario(commands(), text, "printed.scn")) << text.str();

    std::size_t writes = 0;
    for (const ScenarioLine& line : scenario.lines) {
      writes += line.text.find("write ") != std::string::npos ? 1U : 0U;
    }
    EXPECT_EQ(writes, count_writes(steps)) << text.str();
  }
}

TEST(PrintedScenario, TakesTheSameTimeAsTheSequence) {
  const std::vector<test::Step> steps{{{{"ds402_controlword", 0x06}}, 3},
                                      {{{"op_mode_cmd", 5}, {"op_mode_cmd", 1}}, 1}};
  const test::SideBySide run = test::run_side_by_side(steps);
  EXPECT_EQ(test::scenario_of(steps, run.ticks),
            "# vdrived --clock lockstep --config tests/data/whole_units.yaml\n"
            "write 1.1 ds402_controlword 0x6\n"
            "wait 1ms\n"
            "expect 1.1 0x6041 0x231 --throughout 2ms\n"
            "expect 1.1 0x6061 0\n"
            "expect 1.1 0x6062 0\n"
            "expect 1.1 0x606B 0\n"
            "refused 0x06090030 write 1.1 op_mode_cmd 5\n"
            "write 1.1 op_mode_cmd 1\n"
            "wait 1ms\n"
            "expect 1.1 0x6041 0x231\n"
            "expect 1.1 0x6061 1\n"
            "expect 1.1 0x6062 0\n"
            "expect 1.1 0x606B 0\n");
}

}  // namespace
}  // namespace vdrive::tool
