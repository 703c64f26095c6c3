// SPDX-License-Identifier: Apache-2.0
// Every scenario of the project in lock-step, each on its own bench in the process that runs it.
// both_wires_test runs them over DDS.
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;

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
  const std::string file = (kScenarios / (GetParam() + ".scn")).string();
  const Finished finished = Process(VDRIVE_TOOL, {"run", "--private", file}).wait();
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output, HasSubstr("passed"));
}

TEST_P(Scenario, BreaksNoRuleOnEveryDriveThatItDoesNotExcept) {
  const std::string file = (kScenarios / (GetParam() + ".scn")).string();
  const Finished finished = Process(VDRIVE_TOOL, {"test", "--judge", file}).wait();
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.errors, Not(HasSubstr("nothing that this exception covers")));
}

INSTANTIATE_TEST_SUITE_P(Files, Scenario, testing::ValuesIn(scenario_names()),
                         [](const auto& name) {
                           return name.param;
                         });

// A socket or a memory file would belong to a wire, which a bench in the process does not have.
TEST(PrivateRun, OpensNoSocketAndNoMemory) {
  Process call(VDRIVE_TOOL, {"run", "--private", "-"},
               "enable 1.1\nmove 1.1 1000000 --velocity 1 --timeout 3600000\n");
  ASSERT_THAT(call.read_line(), HasSubstr("enable"));
  ASSERT_THAT(call.read_line(), HasSubstr("move"));
  std::vector<std::string> targets;
  for (const auto& entry :
       std::filesystem::directory_iterator("/proc/" + std::to_string(call.id()) + "/fd")) {
    std::error_code closed;
    targets.push_back(std::filesystem::read_symlink(entry.path(), closed));
  }
  EXPECT_THAT(targets, Contains(HasSubstr("pipe:"))) << "its output";
  EXPECT_THAT(targets, Each(AllOf(Not(HasSubstr("socket:")), Not(HasSubstr("memfd:")))));
  call.send(SIGINT);
  EXPECT_EQ(call.wait().code, 130);
}

}  // namespace
}  // namespace vdrive::test
