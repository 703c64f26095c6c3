// SPDX-License-Identifier: Apache-2.0
// The completions of a word of a command line.
#include "base/usage_error.hpp"
#include "command_table.hpp"
#include "language/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

using Words = std::vector<std::string>;

BenchNames some_names() {
  return {.axes =
              [] {
                return Words{"1.1", "x", "1.2", "y"};
              },
          .benches =
              [] {
                return Words{"1"};
              }};
}

Words offers(const Words& words) {
  return complete_words(commands(), words, some_names());
}

TEST(Completion, OffersTheCommands) {
  EXPECT_THAT(offers({"mo"}), ElementsAre("move"));
  EXPECT_THAT(offers({"re"}), Contains("record"));
  EXPECT_THAT(offers({"--domain", "5", "mo"}), ElementsAre("move")) << "5 is no command";
  EXPECT_THAT(offers({"dance", ""}), IsEmpty());
}

TEST(Completion, OffersTheOptionsOfTheCommandAndTheGlobalOnes) {
  EXPECT_THAT(offers({"move", "1.1", "10", "--vel"}), ElementsAre("--velocity"));
  EXPECT_THAT(offers({"move", "1.1", "10", "--js"}), ElementsAre("--json"));
  EXPECT_THAT(offers({"list", "--vel"}), IsEmpty()) << "an option of another command";
  EXPECT_THAT(offers({"--js"}), ElementsAre("--json"));
}

TEST(Completion, OffersNamesOfTheBenches) {
  EXPECT_THAT(offers({"enable", ""}), ElementsAre("1.1", "1.2", "x", "y"));
  EXPECT_THAT(offers({"watch", "1.1", "1.2", "x"}), ElementsAre("x"));
  EXPECT_THAT(offers({"step", "5", "--bench", ""}), ElementsAre("1"));
  EXPECT_THAT(offers({"stop", ""}), ElementsAre("1"));
  EXPECT_THAT(offers({"events", "1"}), ElementsAre("1", "1.1", "1.2"));
}

TEST(Completion, OffersObjectsDisturbancesAndValues) {
  EXPECT_THAT(offers({"read", "1.1", "profile_v"}), ElementsAre("profile_velocity"));
  EXPECT_THAT(offers({"read", "1.1", "profile_velocity", "profile_a"}), ElementsAre("profile_acc"));
  EXPECT_THAT(offers({"disturb", "1.1", "blo"}), ElementsAre("blocked_load"));
  EXPECT_THAT(offers({"write", "1.1", "op_mode_cmd", ""}),
              ElementsAre("0", "1", "10", "2", "3", "4", "6", "7", "8", "9"));
  EXPECT_THAT(offers({"write", "1.1", "app_position_limit_switch", ""}), ElementsAre("0", "1"));
  EXPECT_THAT(offers({"write", "1.1", "profile_velocity", ""}), IsEmpty());
  for (const Words& line :
       {Words{"write", "1.1", "homing_method", "3"}, Words{"home", "1.1", "--method", "3"}}) {
    EXPECT_THAT(offers(line), ElementsAre("3", "30", "33", "34", "35", "37"));
  }
  EXPECT_THAT(offers({"expect", "1.1", "position", ">"}), ElementsAre(">", ">="));
  EXPECT_THAT(offers({"wait", "1.1", "target_r"}), Contains("target_reached"));
  EXPECT_THAT(offers({"dictionary", "--format", "c"}), ElementsAre("csv"));
  EXPECT_THAT(offers({"plot", "a.csv", "--columns", "torque_d"}), ElementsAre("torque_demand"));
  EXPECT_THAT(offers({"snapshot", "r"}), ElementsAre("restore"));
  EXPECT_THAT(offers({"snapshot", "l"}), ElementsAre("list"));
  EXPECT_THAT(offers({"completion", ""}), ElementsAre("bash", "fish", "zsh"));
}

TEST(Completion, LeavesFilesToTheShell) {
  EXPECT_THAT(offers({"run", ""}), IsEmpty());
  EXPECT_THAT(offers({"test", "a.scn", "--junit", ""}), IsEmpty());
}

TEST(Completion, OffersEveryCommandOfTheHelp) {
  std::istringstream help(parse_command_line(commands(), {"--help"}).text);
  std::string line;
  while (std::getline(help, line) && line != "Benches and axes:") {
  }
  const auto words = offers({""});
  std::size_t count = 0;
  while (std::getline(help, line) && line != "Examples:") {
    if (!line.starts_with("  ")) continue;  // the title of a group
    std::istringstream columns(line);
    std::string word;
    columns >> word;
    EXPECT_THAT(words, Contains(word));
    ++count;
  }
  EXPECT_EQ(count, commands().size());
}

TEST(Completion, OfAShellLineOffersTheCommandsOfTheShell) {
  EXPECT_THAT(complete_line(commands(), "enable 1.1", some_names()), ElementsAre("1.1"));
  EXPECT_THAT(complete_line(commands(), "enable ", some_names()), Contains("x"));
  EXPECT_THAT(
      complete_line(commands(), "", some_names()),
      AllOf(Contains("events"), Contains("help"), Contains("quit"), Not(Contains("shell"))));
  EXPECT_THAT(complete_line(commands(), "help mo", some_names()), ElementsAre("move"));
  EXPECT_THAT(complete_line(commands(), "he", some_names()), ElementsAre("help"));
}

TEST(Completion, IsRefusedForAnUnknownShell) {
  EXPECT_THROW(static_cast<void>(parse_command_line(commands(), {"completion", "tcsh"})),
               UsageError);
}

}  // namespace
}  // namespace vdrive::tool
