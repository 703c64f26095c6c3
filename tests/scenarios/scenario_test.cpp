// SPDX-License-Identifier: Apache-2.0
// Every scenario of the project in lock-step, each against a service of its own.
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

const std::filesystem::path kScenarios =
    std::filesystem::path(VDRIVE_SOURCE_DIR) / "clients" / "scenarios";

std::vector<std::string> scenario_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kScenarios)) {
    if (entry.path().extension() == ".scn") names.push_back(entry.path().stem());
  }
  std::ranges::sort(names);
  return names;
}

class Scenario : public testing::TestWithParam<std::string> {};

TEST_P(Scenario, PassesInLockStep) {
  const RunningService service("--clock lockstep");
  const std::string file = (kScenarios / (GetParam() + ".scn")).string();
  const Finished finished = tool({"run", file});
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output, testing::HasSubstr("passed"));
}

INSTANTIATE_TEST_SUITE_P(Files, Scenario, testing::ValuesIn(scenario_names()),
                         [](const auto& name) {
                           return name.param;
                         });

}  // namespace
}  // namespace vdrive::test
