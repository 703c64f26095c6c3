// SPDX-License-Identifier: Apache-2.0
#include "bridge/node_store.hpp"

#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

const Node::Parameters kSavedParameters{{{0x1017, 0}, 100}, {{0x1800, 5}, 1000}};

/// A store whose reports are recorded.
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
  EXPECT_TRUE(kept.store.save(1, kSavedParameters));
  EXPECT_EQ(kept.store.find(1), kSavedParameters);
  EXPECT_THAT(kept.store.find(2), IsEmpty());
}

TEST(NodeStore, HasAFileForEachNode) {
  const test::TemporaryDirectory directory;
  EXPECT_TRUE(KeptStore(directory.path() / "state").store.save(7, kSavedParameters));
  KeptStore next(directory.path() / "state");
  EXPECT_EQ(next.store.find(7), kSavedParameters);
  EXPECT_THAT(next.store.find(8), IsEmpty());
  EXPECT_THAT(next.lines, IsEmpty());
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory.path() / "state")) {
    names.push_back(entry.path().filename().string());
  }
  EXPECT_THAT(names, UnorderedElementsAre("can0.node-7.parameters", "can0.nodes.lock"));
}

TEST(NodeStore, ReportsAFileThatIsDamagedAndLeavesTheDefaults) {
  const test::TemporaryDirectory directory;
  std::ofstream(directory.path() / "can0.node-1.parameters") << "1017:00 00000064\nnonsense\n";
  KeptStore kept(directory.path());
  EXPECT_THAT(kept.store.find(1), IsEmpty());
  ASSERT_EQ(kept.lines.size(), 1U);
  EXPECT_THAT(kept.lines[0], HasSubstr("can0.node-1.parameters: line 2, 'nonsense'"));
}

TEST(NodeStore, RefusesWhatItCannotWriteUntilItCan) {
  const test::TemporaryDirectory directory;
  std::ofstream(directory.path() / "state") << "";
  KeptStore kept(directory.path() / "state");  // no directory
  EXPECT_FALSE(kept.store.save(1, kSavedParameters));
  EXPECT_THAT(kept.store.find(1), IsEmpty()) << "as before";
  ASSERT_EQ(kept.lines.size(), 3U);
  EXPECT_THAT(kept.lines[0], HasSubstr("not locked, 1010h is refused"));
  EXPECT_THAT(kept.lines[1], HasSubstr("cannot be read"));
  EXPECT_THAT(kept.lines[2], HasSubstr("cannot be written"));
  std::filesystem::remove(directory.path() / "state");
  EXPECT_TRUE(kept.store.save(1, kSavedParameters));
  EXPECT_EQ(kept.store.find(1), kSavedParameters);
}

TEST(NodeStore, IsThatOfOneProgram) {
  const test::TemporaryDirectory directory;
  {
    const KeptStore first(directory.path());
    try {
      const KeptStore second(directory.path());
      FAIL() << "both have it";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), "state directory '" + directory.path().string() + "': process " +
                                  std::to_string(::getpid()) +
                                  " has locked can0.nodes.lock: end it, or give this program "
                                  "another directory (--state)");
    }
  }
  EXPECT_NO_THROW(KeptStore(directory.path())) << "its end sets it free";
}

TEST(NodeStore, NoticesAFileThatIsCutAtTheEndOfALineAndReplacesIt) {
  const test::TemporaryDirectory directory;
  const auto file = directory.path() / "can0.node-1.parameters";
  for (const char* const text : {"", "# Comment\n", "1017:00 00000064\n"}) {
    std::ofstream(file) << text;
    KeptStore kept(directory.path());
    EXPECT_THAT(kept.store.find(1), IsEmpty()) << text;
    ASSERT_EQ(kept.lines.size(), 1U) << text;
    EXPECT_THAT(kept.lines[0], HasSubstr("can0.node-1.parameters: it is incomplete")) << text;
    EXPECT_TRUE(kept.store.save(1, {})) << "defaults, too, are written over it";
    EXPECT_TRUE(std::filesystem::file_size(file) > 0) << text;
  }
  KeptStore next(directory.path());
  EXPECT_THAT(next.store.find(1), IsEmpty());
  EXPECT_THAT(next.lines, IsEmpty());
}

TEST(ParametersOfANode, AreOneLineEach) {
  const std::string text = text_of_parameters(kSavedParameters);
  EXPECT_THAT(text, HasSubstr("\n1017:00 00000064\n1800:05 000003E8\nend 2\n"));
  std::string problem;
  EXPECT_EQ(parse_parameters(text, problem), kSavedParameters);
}

TEST(ParametersOfANode, AreRefusedWithTheirLine) {
  const auto problem_of = [](const std::string& text) {
    std::string problem;
    return parse_parameters(text, problem) ? std::string("accepted") : problem;
  };
  EXPECT_EQ(problem_of("end 0\n"), "accepted");
  EXPECT_EQ(problem_of("# 1\n\n1017:00 64\nend 1"), "accepted");
  EXPECT_THAT(problem_of(""), HasSubstr("its last line must be 'end 0'"));
  EXPECT_THAT(problem_of("1017:00 64\n"), HasSubstr("its last line must be 'end 1'"));
  EXPECT_THAT(problem_of("1017:00 64\nend 2\n"), HasSubstr("line 2, 'end 2'"));
  EXPECT_THAT(problem_of("end 0\n1017:00 64\n"), HasSubstr("line 1, 'end 0'"));
  // In order: no such object, an object of the drive, a constant, above its type, then other
  // syntax.
  for (const std::string line :
       {"1234:00 00000001", "607A:00 00000001", "1200:01 00000601", "1017:00 00010000",
        "1017 00 00000064", "1017:00=00000064", "1017:00 ", "10170:0 00000064", "xxxx:00 00000064",
        "1017:00 100000000", "1008:00 00000001"}) {
    EXPECT_THAT(problem_of("# first\n" + line + "\n"), HasSubstr("line 2, '" + line + "'")) << line;
  }
}

}  // namespace
}  // namespace vdrive::canopen
