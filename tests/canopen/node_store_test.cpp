// SPDX-License-Identifier: Apache-2.0
#include "bridge/node_store.hpp"

#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Node::Parameters kSavedParameters{{{0x1017, 0}, 100}, {{0x1800, 5}, 1000}};

/// A store that keeps what it reports.
struct KeptStore {
  explicit KeptStore(const std::filesystem::path& directory) : store(directory, "can0", reports) {}

  std::vector<std::string> lines{};
  bridge::Reports reports{"test", [this](bridge::Severity, const std::string& line) {
                            lines.push_back(line);
                          }};
  NodeStore store;
};

TEST(NodeStore, KeepsInMemoryWhereItHasNoDirectory) {
  KeptStore kept{std::filesystem::path()};
  EXPECT_THAT(kept.store.find(1), IsEmpty());
  kept.store.save(1, kSavedParameters);
  EXPECT_EQ(kept.store.find(1), kSavedParameters);
  EXPECT_THAT(kept.store.find(2), IsEmpty());
}

TEST(NodeStore, HasAFileForEachNode) {
  const test::TemporaryDirectory directory;
  KeptStore(directory.path() / "state").store.save(7, kSavedParameters);
  KeptStore next(directory.path() / "state");
  EXPECT_EQ(next.store.find(7), kSavedParameters);
  EXPECT_THAT(next.store.find(8), IsEmpty());
  EXPECT_THAT(next.lines, IsEmpty());
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory.path() / "state")) {
    names.push_back(entry.path().filename().string());
  }
  EXPECT_THAT(names, ElementsAre("can0.node-7.parameters"));
}

TEST(NodeStore, ReportsAFileThatIsDamagedAndLeavesTheDefaults) {
  const test::TemporaryDirectory directory;
  std::ofstream(directory.path() / "can0.node-1.parameters") << "1017:00 00000064\nnonsense\n";
  KeptStore kept(directory.path());
  EXPECT_THAT(kept.store.find(1), IsEmpty());
  ASSERT_EQ(kept.lines.size(), 1U);
  EXPECT_THAT(kept.lines[0], HasSubstr("can0.node-1.parameters: line 2, 'nonsense'"));
}

TEST(NodeStore, KeepsInMemoryWhatItCannotWrite) {
  const test::TemporaryDirectory directory;
  std::ofstream(directory.path() / "file") << "";
  KeptStore kept(directory.path() / "file");  // no directory
  kept.store.save(1, kSavedParameters);
  EXPECT_EQ(kept.store.find(1), kSavedParameters);
  ASSERT_EQ(kept.lines.size(), 1U);
  EXPECT_THAT(kept.lines[0], HasSubstr("cannot be written"));
}

TEST(ParametersOfANode, AreOneLineEach) {
  const std::string text = text_of_parameters(kSavedParameters);
  EXPECT_THAT(text, HasSubstr("\n1017:00 00000064\n1800:05 000003E8\n"));
  std::string problem;
  EXPECT_EQ(parse_parameters(text, problem), kSavedParameters);
}

TEST(ParametersOfANode, AreRefusedWithTheirLine) {
  const auto problem_of = [](const std::string& text) {
    std::string problem;
    return parse_parameters(text, problem) ? std::string("accepted") : problem;
  };
  EXPECT_EQ(problem_of(""), "accepted");
  EXPECT_EQ(problem_of("# 1\n\n1017:00 64"), "accepted");
  // No such object; the drive's; constant; above its type; other forms.
  for (const std::string line :
       {"1234:00 00000001", "607A:00 00000001", "1200:01 00000601", "1017:00 00010000",
        "1017 00 00000064", "1017:00=00000064", "1017:00 ", "10170:0 00000064", "xxxx:00 00000064",
        "1017:00 100000000", "1008:00 00000001"}) {
    EXPECT_THAT(problem_of("# first\n" + line + "\n"), HasSubstr("line 2, '" + line + "'")) << line;
  }
}

}  // namespace
}  // namespace vdrive::canopen
