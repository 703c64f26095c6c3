// SPDX-License-Identifier: Apache-2.0
// Journals of real services, commanded by the real tool.
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The name of a file that the destructor removes.
class JournalName {
 public:
  JournalName()
      : path_((std::filesystem::temp_directory_path() /
               ("vdrive_journal_" + std::to_string(::getpid())))
                  .string()) {
    std::filesystem::remove(path_);
  }

  ~JournalName() { std::filesystem::remove(path_); }

  JournalName(const JournalName&) = delete;
  JournalName& operator=(const JournalName&) = delete;

  [[nodiscard]] const std::string& text() const { return path_; }

  [[nodiscard]] std::string flag() const { return " --journal " + path_; }

  [[nodiscard]] Finished replay(const std::string& threads) const {
    return Process(VDRIVE_SERVICE, {"--replay", path_, "--threads", threads}).wait();
  }

 private:
  std::string path_;
};

void expect_it_replays(const JournalName& journal, const std::string& text, int code = 0,
                       const std::vector<std::string>& threads_of_replays = {"1", "4"}) {
  for (const std::string& threads : threads_of_replays) {
    const Finished replayed = journal.replay(threads);
    EXPECT_EQ(replayed.code, code) << replayed.errors;
    EXPECT_THAT(replayed.output, HasSubstr("all checks agree"));
    EXPECT_THAT(replayed.output, HasSubstr(text));
    EXPECT_THAT(replayed.output, Not(HasSubstr(" 0 changes")));
  }
}

// Under any of its names: the path, a symbolic link, a hard link.
TEST(Journal, ThatAServiceWritesIsRefusedToAnother) {
  const JournalName journal;
  const std::string linked = journal.text() + ".link";
  const std::string named = journal.text() + ".name";
  RunningService first("--clock lockstep" + journal.flag());
  std::filesystem::remove(linked);
  std::filesystem::remove(named);
  std::filesystem::create_symlink(journal.text(), linked);
  std::filesystem::create_hard_link(journal.text(), named);
  for (const std::string& name : {journal.text(), linked, named}) {
    const Finished second =
        Process(VDRIVE_SERVICE, tool_arguments("--bench 2 --clock lockstep --journal " + name))
            .wait();
    EXPECT_EQ(second.code, 1) << name;
    EXPECT_THAT(second.errors,
                HasSubstr("journal " + name + ": is being written by another bench, process " +
                          std::to_string(first.id()) + " (vdrived) on this host"));
  }
  EXPECT_EQ(tool("step 100").code, 0);
  EXPECT_EQ(first.stop().code, 0);
  EXPECT_EQ(journal.replay("1").code, 0) << "nothing else was written";
  std::filesystem::remove(linked);
  std::filesystem::remove(named);
}

/// Moves axes, and injects and resets faults, as users do.
void use() {
  for (const char* const words :
       {"enable 1.1", "enable 1.2", "move 1.1 100 --velocity 1000", "disturb 1.2 load_torque 500",
        "move 1.2 -200 --relative --velocity 2000", "disturb 1.1 over_current 1",
        "disturb 1.1 none", "reset 1.1", "power-cycle 1.2"}) {
    const Finished finished = tool(words);
    EXPECT_EQ(finished.code, 0) << words << ": " << finished.errors;
  }
}

TEST(JournalOfTheService, RecordsInLockStepAndReplays) {
  const JournalName journal;
  RunningService service("--clock lockstep --axes 20" + journal.flag());
  use();
  EXPECT_EQ(tool("snapshot take").code, 0);
  EXPECT_EQ(tool("step 2000").code, 0);
  EXPECT_EQ(tool("snapshot restore 1").code, 0);
  EXPECT_EQ(tool("step 2000").code, 0);
  service.stop();
  expect_it_replays(journal, " ticks of 20 axes, ");
}

/// Clocks that run on their own, without steps.
class JournalOfAClock : public testing::TestWithParam<std::string> {};

TEST_P(JournalOfAClock, RecordsAndReplays) {
  const JournalName journal;
  RunningService service("--axes 20 --clock " + GetParam() + journal.flag());
  use();
  service.stop();
  // By now, a freerun bench has run a million ticks or more. On a busy machine, replaying
  // them with threads that synchronise in each tick would take minutes.
  if (GetParam() == "freerun") {
    expect_it_replays(journal, " ticks of 20 axes, ", 0, {"1"});
  } else {
    expect_it_replays(journal, " ticks of 20 axes, ");
  }
}

INSTANTIATE_TEST_SUITE_P(Clocks, JournalOfAClock, testing::Values("realtime", "freerun"),
                         [](const auto& clock) {
                           return clock.param;
                         });

TEST(JournalOfTheService, OfAKilledServiceReplaysUpToItsEnd) {
  const JournalName journal;
  RunningService service("--clock lockstep --axes 20" + journal.flag());
  use();
  EXPECT_EQ(tool("step 5000").code, 0);  // some chunks are full
  service.kill();
  expect_it_replays(journal, "the journal ends early, without an end mark", 1);
}

TEST(JournalOfTheService, IsRefusedForAnUnwritableFile) {
  for (const std::string file : {"/nonexistent/journal", "/dev/full"}) {
    const Finished finished =
        Process(VDRIVE_SERVICE, {"--journal", file, "--domain", std::to_string(test_domain()),
                                 "--log-level", "off"})
            .wait();
    EXPECT_EQ(finished.code, 1);
    EXPECT_THAT(finished.errors, HasSubstr(file));
  }
  EXPECT_EQ(Process(VDRIVE_SERVICE, {"--replay", "/nonexistent/journal"}).wait().code, 2);
}

}  // namespace
}  // namespace vdrive::test
