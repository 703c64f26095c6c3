// SPDX-License-Identifier: Apache-2.0
// `vdrive test --shard` and `--merge`: runs on private benches, divided and merged.
#include "support/signals.hpp"
#include "tool/json_lines.hpp"
#include "tool/marked_calls.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Shards : public MarkedCalls {
 protected:
  Shards() {
    for (const char* const name : {"e", "c", "a", "d", "b"}) {
      add(name, std::string("expect 1.1 position 0\nenable 1.1\n") +
                    (*name == 'c' ? "expect 1.1 position 5\n" : "step 10\n"));
    }
  }

  void add(const std::string& name, const std::string& lines) const {
    std::filesystem::create_directories(tests_);
    std::ofstream(tests_ / (name + ".scn")) << lines;
  }

  /// Runs one shard and adds its report to the reports.
  [[nodiscard]] Finished run(int number, int count, std::vector<std::string> more = {}) const {
    std::filesystem::create_directories(reports_);
    more.insert(more.begin(),
                {tests_.string(), "--shard", std::to_string(number) + "/" + std::to_string(count),
                 "--junit", of_shard(number)});
    return start("test", std::move(more)).wait();
  }

  void run_all(int count) const {
    std::filesystem::remove_all(reports_);
    for (int number = 1; number <= count; ++number) {
      const Finished finished = run(number, count);
      ASSERT_LE(finished.code, 1) << finished.errors;
    }
  }

  [[nodiscard]] Finished merge(std::vector<std::string> reports = {}) const {
    if (reports.empty()) reports.push_back(reports_);
    reports.insert(reports.end(), {"--merge", "--junit", report()});
    return start("test", std::move(reports)).wait();
  }

  [[nodiscard]] std::string of_shard(int number) const {
    return reports_ / (std::to_string(number) + ".xml");
  }

  /// @return the merged report without its times.
  [[nodiscard]] std::string merged() const {
    return std::regex_replace(text_of(report()), std::regex(R"re( time="[0-9.]+")re"), "");
  }

  [[nodiscard]] std::filesystem::path reports() const { return reports_; }

  [[nodiscard]] std::filesystem::path tests() const { return tests_; }

 private:
  const std::filesystem::path tests_ = std::filesystem::path(report()).parent_path() / "tests";
  const std::filesystem::path reports_ = std::filesystem::path(report()).parent_path() / "reports";
};

TEST_F(Shards, AreOneReportAgainHoweverManyThereAre) {
  ASSERT_EQ(start("test", {tests().string(), "--junit", report()}).wait().code, 1);
  const std::string whole = merged();
  EXPECT_THAT(whole, HasSubstr("tests=\"15\" failures=\"1\""));
  for (const int count : {1, 2, 7}) {
    run_all(count);
    const Finished finished = merge();
    EXPECT_EQ(finished.code, 1) << finished.errors;
    const std::string shards = std::to_string(count) + (count == 1 ? " shard" : " shards");
    EXPECT_EQ(finished.output, std::to_string(count) + " of " + shards + ": 4 of 5 files passed\n");
    EXPECT_THAT(finished.errors, HasSubstr("c.scn:3: expect 1.1 position 5: position: expected 5"));
    EXPECT_EQ(merged(), whole);
  }
  EXPECT_TRUE(all_have_ended());
}

TEST_F(Shards, WithoutAFilePassWithAnEmptyReport) {
  const Finished finished = run(6, 7);
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_EQ(finished.output, "shard 6 of 7: 0 of 0 files passed\n");
  EXPECT_THAT(text_of(of_shard(6)), AllOf(HasSubstr("<testsuites tests=\"0\""),
                                          HasSubstr("<property name=\"shard\" value=\"6\"/>"),
                                          HasSubstr("<property name=\"files\" value=\"5\"/>")));
}

TEST_F(Shards, OfAFolderThatAClusterMountsHaveEachFileOnce) {
  // Like a mounted ConfigMap: links to a folder that has a different name on each machine.
  std::filesystem::create_directories(tests() / "..2026_11_30");
  std::filesystem::rename(tests() / "a.scn", tests() / "..2026_11_30" / "a.scn");
  std::filesystem::create_directory_symlink("..2026_11_30", tests() / "..data");
  std::filesystem::create_symlink("..data/a.scn", tests() / "a.scn");
  const Finished finished = run(1, 5);
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output, AllOf(HasSubstr("tests/a.scn, 3 lines"),
                                     HasSubstr("shard 1 of 5: 1 of 1 file passed")));
}

// A variable that only occurs in the file of another shard is not a typo.
TEST_F(Shards, KnowTheVariablesOfTheFilesOfOthers) {
  add("b", "let axis = 9.9\nexpect ${axis} position 0\n");
  EXPECT_EQ(run(1, 5, {"--set", "axis=1.1"}).code, 0);
  EXPECT_EQ(run(2, 5, {"--set", "axis=1.1"}).code, 0);
  EXPECT_EQ(run(1, 5, {"--set", "axes=1.1"}).code, 2);
}

TEST_F(Shards, WithoutAReportAreNamedAndMustBeRepeated) {
  ASSERT_EQ(run(1, 4).code, 0);  // a, e; c is in shard 3
  std::ofstream(of_shard(2)) << "";
  std::ofstream(of_shard(4)) << text_of(of_shard(1)).substr(0, 300);
  const Finished finished = merge({reports().string(), "--json"});
  EXPECT_EQ(finished.code, 6);
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("reports/2.xml: is empty"),
                                     HasSubstr("reports/4.xml: is truncated or not XML, at line "),
                                     HasSubstr("vdrive: no report of shard 2, 3, 4 of 4\n")));
  EXPECT_EQ(Json::parse(finished.output),
            Json::parse(R"({"shards":4,"missing":[2,3,4],"files":5,"passed":2})"));
  EXPECT_THAT(merged(), AllOf(HasSubstr("tests=\"11\" failures=\"0\" skipped=\"0\" errors=\"5\""),
                              HasSubstr("<testsuite name=\"shard 3 of 4\""),
                              HasSubstr("message=\"has no report\" type=\"not_run\"")));
  ASSERT_EQ(run(3, 4).code, 1);
  EXPECT_EQ(merge().code, 1) << "a test has failed, whatever else is missing";
}

TEST_F(Shards, ThatWereInterruptedHaveFilesThatWereNotRun) {
  add("a", "enable 1.1\nmove 1.1 1000000 --velocity 1 --timeout 3600000\n");
  std::filesystem::remove(tests() / "c.scn");
  std::filesystem::create_directories(reports());
  Process call =
      start("test", {tests().string(), "--shard", "1/2", "--jobs", "1", "--junit", of_shard(1)});
  ASSERT_TRUE(wait_for_process({"a.scn", "--private"}));
  call.send(SIGTERM);
  ASSERT_EQ(call.wait().code, 130);
  ASSERT_EQ(run(2, 2).code, 0);
  const Finished finished = merge();
  EXPECT_EQ(finished.code, 6) << finished.errors;
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("a.scn"), HasSubstr("d.scn: was not run\n")));
  EXPECT_EQ(finished.output, "2 of 2 shards: 2 of 4 files passed\n");
}

TEST_F(Shards, WhoseReportsAreFromDifferentRunsAreRefused) {
  run_all(2);
  ASSERT_EQ(run(3, 3).code, 1);  // has c, which fails
  EXPECT_THAT(merge().errors,
              AllOf(HasSubstr("3.xml: belongs to shard 3 of 3, "),
                    HasSubstr("1.xml to shard 1 of 2: they are from different runs\n")));
  std::filesystem::copy_file(of_shard(2), of_shard(3),
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(merge().errors, HasSubstr("3.xml: belongs to shard 2 of 2, as does "));
  std::filesystem::remove(of_shard(3));
  add("f", "enable 1.1\n");
  ASSERT_EQ(run(2, 2).code, 0);
  EXPECT_THAT(merge().errors,
              HasSubstr("shard 2 of 2 is of 6 files, others of 5: they are from different runs"));
  std::filesystem::rename(tests() / "b.scn", tests() / "0.scn");
  std::filesystem::remove(tests() / "f.scn");
  ASSERT_EQ(run(2, 2).code, 0);
  const Finished finished = merge();
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors,
              HasSubstr("a.scn: is in the reports of shard 1 and shard 2: the shards were "
                        "given different files"));
  EXPECT_THAT(merged(), HasSubstr("errors=\"1\""));
}

TEST_F(Shards, IgnoreAnEarlierMergedReport) {
  run_all(2);
  const std::string output = reports() / "all.xml";
  for (int i = 0; i < 2; ++i) {
    const Finished finished =
        start("test", {"--merge", reports().string(), "--junit", output}).wait();
    EXPECT_EQ(finished.code, 1) << finished.errors;
    EXPECT_THAT(finished.output, HasSubstr("2 of 2 shards: 4 of 5 files passed"));
  }
  const Finished same = start("test", {"--merge", output, "--junit", output}).wait();
  EXPECT_EQ(same.code, 2);
  EXPECT_THAT(same.errors, HasSubstr("all.xml' is one of the reports to merge"));
}

TEST_F(Shards, RefuseToMergeFilesThatAreNoReports) {
  EXPECT_THAT(merge({tests().string()}).errors, HasSubstr("tests' has no report, *.xml"));
  EXPECT_THAT(merge({"/nonexistent.xml"}).errors, HasSubstr("no report '/nonexistent.xml'"));
  ASSERT_EQ(start("test", {(tests() / "a.scn").string(), "--junit", tests() / "a.xml"}).wait().code,
            0);
  const Finished finished = merge({tests().string()});
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors, HasSubstr("a.xml: does not belong to a shard"));
  for (const char* const option : {"--shard=1/2", "--jobs=2", "--set=a=1", "--over=local"}) {
    EXPECT_THAT(merge({tests().string(), option}).errors, HasSubstr("--merge runs nothing: "));
  }
}

// A failed test fails again; resources missing on one machine may be available the next time.
TEST_F(Shards, DistinguishAFailedTestFromAMachineThatDoesNotRunIt) {
  const std::string good = (tests() / "a.scn").string();
  const std::string bad = (tests() / "c.scn").string();
  const Finished full = start("test", {good, "--junit", "/dev/full"}).wait();
  EXPECT_EQ(full.code, 6);
  EXPECT_THAT(full.errors, HasSubstr("cannot write the report '/dev/full'"));
  EXPECT_EQ(start("test", {bad, "--junit", "/dev/full"}).wait().code, 1);
  const Finished unstarted =
      start("test", {good, "--over", "dds", "--service", "/bin/false", "--junit", report()}).wait();
  EXPECT_EQ(unstarted.code, 6) << unstarted.errors;
  EXPECT_THAT(text_of(report()), HasSubstr("type=\"not_run\""));
}

TEST_F(Shards, WhoseFileIsKilledWantToBeRepeatedUnlessAnotherOneFailed) {
  add("b", "enable 1.1\nmove 1.1 1000000 --velocity 1 --timeout 3600000\n");
  for (const char* const other : {"a.scn", "c.scn"}) {
    Process call = start("test", {(tests() / "b.scn").string(), (tests() / other).string()});
    const auto run = wait_for_process({"--private", "b.scn"});
    ASSERT_TRUE(run);
    send_signal(*run, SIGKILL);
    const Finished finished = call.wait();
    EXPECT_EQ(finished.code, *other == 'a' ? 6 : 1);
    EXPECT_THAT(finished.errors, HasSubstr("ended by signal 9"));
  }
  EXPECT_TRUE(all_have_ended());
}

}  // namespace
}  // namespace vdrive::test
