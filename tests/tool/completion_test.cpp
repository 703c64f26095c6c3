// SPDX-License-Identifier: Apache-2.0
// The script of `vdrive completion bash`, carried out by bash.
#include "grammar.hpp"
#include "usage_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

std::string script() {
  return tool::parse_command_line({"completion", "bash"}).text;
}

/// @return what bash offers for the last of the words.
std::vector<std::string> offers(const std::string& words, int last) {
  // The script has no single quotes that would end those of the command.
  const std::string command = "bash -c '" + script() + "COMP_WORDS=(" + words +
                              "); COMP_CWORD=" + std::to_string(last) +
                              "; _vdrive; printf \"%s\\n\" \"${COMPREPLY[@]}\"'";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::vector<std::string> lines;
  std::array<char, 256> line{};
  while (std::fgets(line.data(), line.size(), pipe.get()) != nullptr) {
    std::string text = line.data();
    text.pop_back();
    if (!text.empty()) lines.push_back(text);
  }
  return lines;
}

TEST(Completion, OffersTheWords) {
  EXPECT_THAT(offers("vdrive mo", 1), ElementsAre("move"));
  EXPECT_THAT(offers("vdrive re", 1), Contains("record"));
}

TEST(Completion, OffersTheOptionsOfTheWordAndTheGlobalOnes) {
  EXPECT_THAT(offers("vdrive move 1.1 10 --vel", 4), ElementsAre("--velocity"));
  EXPECT_THAT(offers("vdrive move 1.1 10 --js", 4), ElementsAre("--json"));
  EXPECT_THAT(offers("vdrive list --vel", 2), IsEmpty()) << "an option of another word";
}

TEST(Completion, DoesNotTakeTheValueOfAnOptionForTheWord) {
  EXPECT_THAT(offers("vdrive --domain 5 mo", 3), ElementsAre("move"));
}

TEST(Completion, KnowsEveryWordOfTheHelp) {
  std::istringstream help(tool::parse_command_line({"--help"}).text);
  std::string line;
  while (std::getline(help, line) && line != "Subcommands:") {
  }
  const auto words = offers("vdrive ", 1);
  std::size_t count = 0;
  while (std::getline(help, line) && line.starts_with("  ")) {
    std::istringstream columns(line);
    std::string word;
    columns >> word;
    EXPECT_THAT(words, Contains(word));
    ++count;
  }
  EXPECT_GT(count, 20U);
}

TEST(Completion, IsRefusedForAnotherShell) {
  EXPECT_THROW(static_cast<void>(tool::parse_command_line({"completion", "tcsh"})),
               tool::UsageError);
}

}  // namespace
}  // namespace vdrive::test
