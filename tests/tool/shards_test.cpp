// SPDX-License-Identifier: Apache-2.0
// Scenarios shared by several machines: the selection of a shard, and reading reports back. Nothing
// is run.
#include "scenarios/shards.hpp"

#include "base/usage_error.hpp"
#include "output/junit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

/// Sets environment variables for the lifetime of the object; other job variables are unset.
class JobVariables {
 public:
  explicit JobVariables(const std::map<std::string, std::string>& variables) {
    clear();
    for (const auto& [name, value] : variables) {
      setenv(name.c_str(), value.c_str(), 1);  // NOLINT(*-mt-unsafe): one thread
    }
  }

  ~JobVariables() { clear(); }

  JobVariables(const JobVariables&) = delete;
  JobVariables& operator=(const JobVariables&) = delete;

 private:
  static void clear() {
    for (const char* const name : {"JOB_COMPLETION_INDEX", "SLURM_ARRAY_TASK_ID",
                                   "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_COUNT"}) {
      unsetenv(name);  // NOLINT(*-mt-unsafe): one thread
    }
  }
};

constexpr const char* kAccepted = "accepted";

/// @param parse throws UsageError for a mistake
/// @return its message
template <typename Parse>
std::string mistake_in_shards(Parse parse, const std::string& text) {
  try {
    static_cast<void>(parse(text));
  } catch (const UsageError& error) {
    return error.what();
  }
  return kAccepted;
}

std::string mistake_of_shard(const std::string& text) {
  return mistake_in_shards(parse_shard, text);
}

std::string mistake_of_report(const std::string& xml) {
  return mistake_in_shards(read_junit, xml);
}

std::map<std::string, std::string> task_of_array(const std::string& task) {
  return {{"SLURM_ARRAY_TASK_ID", task},
          {"SLURM_ARRAY_TASK_MIN", "5"},
          {"SLURM_ARRAY_TASK_COUNT", "3"}};
}

TEST(Shard, IsOneOfSeveral) {
  EXPECT_EQ(parse_shard("2/7").number, 2U);
  EXPECT_EQ(parse_shard("2/7").count, 7U);
  EXPECT_EQ(parse_shard("100000/100000").number, 100'000U);
}

TEST(Shard, OutOfItsRangeIsRefusedWithTheRange) {
  EXPECT_EQ(mistake_of_shard("0/3"), "--shard: '0/3': the shards are 1 to 3");
  EXPECT_EQ(mistake_of_shard("4/3"), "--shard: '4/3': the shards are 1 to 3");
  for (const char* const text : {"x", "3", "3/", "/", "/0", "0/0", "-1/3", "1/x", "x/3", "1/2/3",
                                 "1/100001", "1/99999999999999999999"}) {
    EXPECT_THAT(mistake_of_shard(text), AllOf(HasSubstr("'" + std::string(text) + "' is not I/N"),
                                              HasSubstr("N is from 1 to 100000")));
  }
}

TEST(Shard, IsThatOfTheTaskOfAnIndexedJob) {
  const JobVariables job({{"JOB_COMPLETION_INDEX", "6"}});
  EXPECT_EQ(parse_shard("/7").number, 7U);
  EXPECT_EQ(parse_shard("/7").count, 7U);
  EXPECT_EQ(parse_shard("3/7").number, 3U) << "what was typed";
  EXPECT_EQ(mistake_of_shard("/6"), "--shard /6: JOB_COMPLETION_INDEX is 6, task 7 of 6");
}

TEST(Shard, IsThatOfTheTaskOfASlurmArrayWhateverItsFirstNumber) {
  const JobVariables job(task_of_array("7"));
  EXPECT_EQ(parse_shard("/3").number, 3U);
  EXPECT_THAT(mistake_of_shard("/7"), AllOf(HasSubstr("--shard /7: the array has 3 tasks"),
                                            HasSubstr("SLURM_ARRAY_TASK_COUNT"), HasSubstr("I/N")));
}

TEST(Shard, OfATaskOutsideOfItsArrayIsRefused) {
  const JobVariables list(task_of_array("9"));  // --array=5,6,9
  EXPECT_EQ(mistake_of_shard("/3"), "--shard /3: SLURM_ARRAY_TASK_ID is 9, task 5 of 3");
}

TEST(Shard, OfNoJobIsRefusedWithTheVariablesItNeeds) {
  {
    const JobVariables none({});
    EXPECT_THAT(mistake_of_shard("/7"), AllOf(HasSubstr("JOB_COMPLETION_INDEX"),
                                              HasSubstr("SLURM_ARRAY_TASK_ID"), HasSubstr("1/7")));
  }
  {
    const JobVariables wrong({{"JOB_COMPLETION_INDEX", "first"}});
    EXPECT_THAT(mistake_of_shard("/7"), HasSubstr("'first' is not a valid JOB_COMPLETION_INDEX"));
  }
  {
    const JobVariables alone({{"SLURM_ARRAY_TASK_ID", "1"}});
    EXPECT_THAT(mistake_of_shard("/7"), HasSubstr("SLURM_ARRAY_TASK_COUNT"));
  }
  auto variables = task_of_array("5");
  variables["JOB_COMPLETION_INDEX"] = "0";
  const JobVariables both(variables);
  EXPECT_THAT(mistake_of_shard("/3"),
              HasSubstr("both JOB_COMPLETION_INDEX and SLURM_ARRAY_TASK_ID"));
}

std::vector<std::string> files_of(std::size_t number, std::size_t count,
                                  const std::vector<std::string>& names) {
  std::vector<Scenario> scenarios;
  for (const std::string& name : names) scenarios.push_back({.file = name});
  Shard shard{.number = number, .count = count};
  std::vector<std::string> files;
  for (const Scenario& each : dealt_to(shard, std::move(scenarios))) files.push_back(each.file);
  return files;
}

TEST(Shards, HaveEachFileOnceAndNearlyTheSameNumberOfFiles) {
  std::vector<std::string> names;
  for (int i = 10; i < 23; ++i) names.push_back("tests/" + std::to_string(i) + ".scn");
  for (const std::size_t count : {1U, 2U, 7U, 13U, 20U}) {
    std::vector<std::string> all;
    for (std::size_t number = 1; number <= count; ++number) {
      const std::vector<std::string> files = files_of(number, count, names);
      EXPECT_GE(files.size(), names.size() / count);
      EXPECT_LE(files.size(), names.size() / count + 1);
      all.insert(all.end(), files.begin(), files.end());
    }
    std::ranges::sort(all);
    EXPECT_EQ(all, names) << count;
  }
}

TEST(Shards, DoNotDependOnTheOrderInWhichTheFilesWereNamed) {
  const std::vector<std::string> names{"d.scn", "a.scn", "c.scn", "b.scn", "c.scn"};
  EXPECT_EQ(files_of(1, 2, names), (std::vector<std::string>{"a.scn", "c.scn"}));
  EXPECT_EQ(files_of(2, 2, names), (std::vector<std::string>{"b.scn", "d.scn"}));
}

/// @return a report with every feature that a report may have.
std::string whole_report() {
  const std::vector<JunitCase> cases{
      {.name = "line 1: wait 1s", .duration = 1'500'250us, .line = 1, .output = "<1>\n2 & 3\n"},
      {.name = "line 7: expect 1.1 mode 3",
       .failure = "expected \"3\"",
       .line = 7,
       .type = "expectation",
       .text = "lift.scn:7: mode <> 3\n  next: look"},
      {.name = "line 8", .is_skipped = true, .line = 8},
      {.name = "end", .error = "ended by signal 9", .type = JunitCase::kNotRun}};
  return junit_xml({{"lift.scn", cases}, {"none.scn", {}}},
                   Shard{.number = 2, .count = 7, .files = 13});
}

TEST(Junit, IsReadAsItWasWritten) {
  const std::string xml = whole_report();
  const JunitContent content = read_junit(xml);
  ASSERT_TRUE(content.shard);
  EXPECT_EQ(content.shard->number, 2U);
  EXPECT_EQ(content.shard->count, 7U);
  EXPECT_EQ(content.shard->files, 13U);
  EXPECT_EQ(junit_xml(content.suites, content.shard), xml);
}

TEST(Junit, WithoutAValidShardHasNone) {
  EXPECT_FALSE(read_junit(junit_xml({})).shard);
  EXPECT_TRUE(read_junit(junit_xml({}, Shard{.number = 3, .count = 3})).shard);
  EXPECT_FALSE(read_junit(junit_xml({}, Shard{.number = 4, .count = 3})).shard);
  EXPECT_FALSE(read_junit(junit_xml({}, Shard{.number = 1, .count = 100'001})).shard);
}

TEST(Junit, TruncatedAnywhereIsReportedAsTruncated) {
  const std::string xml = whole_report();
  for (std::size_t size = 1; size + 1 < xml.size(); ++size) {
    EXPECT_NE(mistake_of_report(xml.substr(0, size)), kAccepted) << size;
  }
  EXPECT_THAT(mistake_of_report(xml.substr(0, xml.size() / 2)),
              HasSubstr("is truncated or not XML, at line "));
  EXPECT_EQ(mistake_of_report(""), "is empty: its run ended before it was written");
  EXPECT_THAT(mistake_of_report("<testsuite name=\"a\"/>"), HasSubstr("no element testsuites"));
}

}  // namespace
}  // namespace vdrive::tool
