// SPDX-License-Identifier: Apache-2.0
// `vdrive test --judge`: scenarios judged as masters, on private benches.
#include "tool/marked_calls.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kRight = "enable 1.1\nmove 1.1 1000\ndisable 1.1\n";
constexpr const char* kBit4Stays =
    "write 1.1 0x6060 1\nenable 1.1\nwrite 1.1 0x607A 100000\nwrite 1.1 0x6040 0x1F\nstep 3\n"
    "write 1.1 0x607A 200000\nwrite 1.1 0x6040 0x1F\nstep 3\nwrite 1.1 0x6040 0x0F\nstep 3\n";

class JudgedScenarios : public MarkedCalls {
 protected:
  void add(const std::string& name, const std::string& lines) const {
    std::filesystem::create_directories(tests_);
    std::ofstream(tests_ / (name + ".scn")) << lines;
  }

  [[nodiscard]] Finished judge(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {tests_.string(), "--judge", "--junit", report()});
    return start("test", std::move(more)).wait();
  }

  [[nodiscard]] std::string scenario(const std::string& name) const {
    return (tests_ / (name + ".scn")).string();
  }

  [[nodiscard]] std::filesystem::path directory() const { return tests_; }

 private:
  const std::filesystem::path tests_ = std::filesystem::path(report()).parent_path() / "tests";
};

TEST_F(JudgedScenarios, FailByWhatTheirMasterDoesWrong) {
  add("right", kRight);
  add("wrong", kBit4Stays);
  const Finished done = judge();
  EXPECT_EQ(done.code, 1) << done.errors;
  EXPECT_THAT(done.output, AllOf(HasSubstr("passed  " + scenario("right")),
                                 HasSubstr("failed  " + scenario("wrong"))));
  EXPECT_THAT(done.errors, HasSubstr("error handshake-2 on axis 1.1: "));
  const std::string xml = text_of(report());
  EXPECT_THAT(xml, HasSubstr("name=\"judge\""));
  EXPECT_THAT(xml, HasSubstr("handshake-2"));
}

TEST_F(JudgedScenarios, PassWithAnExceptionThatHasAReason) {
  add("wrong",
      "# judge: off handshake-2 because this file is about it\n" + std::string(kBit4Stays));
  const Finished done = judge();
  EXPECT_EQ(done.code, 0) << done.errors;
  EXPECT_THAT(done.errors, Not(HasSubstr("covers")));
}

TEST_F(JudgedScenarios, ReportAnUnusedExceptionAndRefuseAnInvalidOne) {
  add("unused", "# judge: off handshake-2 on 1.1 because nobody does it\n" + std::string(kRight));
  Finished done = judge();
  EXPECT_EQ(done.code, 0) << done.errors;
  EXPECT_THAT(done.errors,
              HasSubstr("unused.scn:1: the judge found nothing that this exception covers"));
  add("unused", "# judge: off handshake-2\n" + std::string(kRight));
  done = judge();
  EXPECT_EQ(done.code, 7) << done.errors;
  EXPECT_THAT(done.errors,
              HasSubstr("unused.scn:1: write '# judge: off RULE [on AXIS] because REASON'"));
  add("unused", "# judge: off handshake-99 because there is no such rule\n" + std::string(kRight));
  EXPECT_THAT(judge().errors, HasSubstr("'handshake-99' is not a rule"));
}

TEST_F(JudgedScenarios, FailFromTheSeverityOnThatIsAskedFor) {
  const std::string excepted =
      "# judge: off state-2 because the tool sends the words up to Operation enabled at once\n";
  add("right", excepted + kRight);
  EXPECT_EQ(judge({"--fail-on", "warning"}).code, 0);
  // The scenario leaves its axis enabled, which is a warning.
  add("right", excepted + "enable 1.1\nmove 1.1 1000\n");
  EXPECT_EQ(judge().code, 0);
  EXPECT_EQ(judge({"--fail-on", "warning"}).code, 1);
  EXPECT_EQ(start("test", {scenario("right"), "--fail-on", "warning"}).wait().code, 2)
      << "it would judge nothing";
}

TEST_F(JudgedScenarios, LeaveAJournalWhereItIsAskedFor) {
  add("right", kRight);
  const std::string journal = (directory() / "run.journal").string();
  ASSERT_EQ(start("run", {scenario("right"), "--private", "--journal", journal}).wait().code, 0);
  EXPECT_EQ(start("judge", {journal}).wait().code, 0);
  EXPECT_EQ(start("judge", {journal, "--node", "5"}).wait().code, 2) << "a bench has no nodes";
  EXPECT_EQ(start("run", {scenario("right"), "--private", "--journal", journal}).wait().code, 6)
      << "it is there already";
}

}  // namespace
}  // namespace vdrive::test
