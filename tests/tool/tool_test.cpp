// SPDX-License-Identifier: Apache-2.0
// The commands of vdrive: exit codes, JSON, streams.
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"
#include "tool/json_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

TEST(Tool, ShowsTheDictionaryWithoutAService) {
  EXPECT_THAT(call("dictionary").output, HasSubstr("ds402_statusword"));
  EXPECT_THAT(call("dictionary --format csv --language zh").output, HasSubstr("402 状态字"));
  EXPECT_FALSE(json_of(call("dictionary --json")).empty());
  EXPECT_THAT(call("dictionary --format eds").output, HasSubstr("\n[ManufacturerObjects]\n"));
  EXPECT_GT(json_of(call("dictionary --format node-json")).size(),
            json_of(call("dictionary --json")).size());
  EXPECT_EQ(call("dictionary 0x6041 --format eds").code, 2);
}

TEST(Tool, PrintsAUsageErrorAsAnObjectWithJson) {
  for (const char* const words :
       {"enabel 1.1 --json", "--json move 1.1 ten", "status --json --x"}) {
    const Finished finished = call(words);
    EXPECT_EQ(finished.code, 2) << words;
    const auto objects = json_of(finished);
    ASSERT_EQ(objects.size(), 1) << words;
    EXPECT_EQ(objects[0]["outcome"], "usage");
    EXPECT_EQ("vdrive: " + objects[0]["message"].get<std::string>() + "\n", finished.errors);
  }
}

TEST(Tool, ExitsTwoOnAUsageErrorAndNamesIt) {
  for (const char* const words : {"", "dance", "move 1.1", "write 1.1 0x6060 300",
                                  "read 1.1 statuswort!", "run /no/such/file.scn"}) {
    const Finished finished = call(words);
    EXPECT_EQ(finished.code, 2) << words;
    EXPECT_THAT(finished.errors, HasSubstr("vdrive: ")) << words;
    EXPECT_THAT(finished.output, IsEmpty()) << words;
  }
}

class ToolInLockStep : public testing::Test {
 protected:
  BenchOnWire bench_{"--clock lockstep"};
};

TEST_F(ToolInLockStep, DrivesAnAxisFromEnableToDisable) {
  for (const char* const words :
       {"list", "status 1.1", "enable 1.1", "move 1.1 1000", "move 1.1 -500 --relative",
        "move 1.1 5000 --velocity 1000 --no-wait", "step 100", "halt 1.1", "resume 1.1",
        "quick-stop 1.1", "enable 1.1", "disable 1.1", "disturb 1.1 over_current", "step 2",
        "disturb 1.1 none", "reset 1.1", "power-cycle 1.1", "watch 1.1 1.2 --count 1"}) {
    const Finished finished = call(words);
    EXPECT_EQ(finished.code, 0) << words << ": " << finished.errors;
    EXPECT_THAT(finished.output, Not(IsEmpty())) << words;
  }
}

TEST_F(ToolInLockStep, ReadPrintsTheDocumentedJson) {
  const Finished finished = call("read 1.1 0x6041 0x607D:1 --json");
  ASSERT_EQ(finished.code, 0) << finished.errors;
  EXPECT_EQ(finished.output,
            R"({"axis":"1.1","index":"0x6041","subindex":0,"name":"ds402_statusword","value":592,)"
            R"("tick":0})"
            "\n"
            R"({"axis":"1.1","index":"0x607D","subindex":1,"name":"user_position_lower_limit",)"
            R"("value":-2147483648,"unit":"deg","value_in_unit":-188743680.0,"tick":0})"
            "\n");
}

TEST_F(ToolInLockStep, EveryCommandPrintsTheDocumentedJson) {
  const auto fields = [](const std::string& words) {
    const auto objects = json_of(call(words + " --json"));
    return objects.empty() ? std::vector<std::string>{} : keys(objects.front());
  };
  EXPECT_THAT(fields("list"),
              ElementsAre("axis", "bench", "bench_name", "clock", "period_us", "host", "version",
                          "name", "state", "statusword", "owner", "owner_name", "tick"));
  EXPECT_THAT(fields("enable 1.1"),
              ElementsAre("axis", "command", "outcome", "tick", "state", "statusword", "position",
                          "unit", "position_in_unit"));
  EXPECT_THAT(fields("move 1.1 10"),
              ElementsAre("axis", "command", "outcome", "tick", "state", "statusword", "position",
                          "unit", "position_in_unit"));
  EXPECT_THAT(fields("write 1.1 0x6081 5"),
              ElementsAre("axis", "index", "subindex", "name", "value", "unit", "value_in_unit",
                          "outcome", "tick"));
  EXPECT_THAT(fields("disturb 1.1 load_torque 5"),
              ElementsAre("axis", "index", "subindex", "name", "value", "outcome", "tick"));
  EXPECT_THAT(fields("disturb 1.1 none"),
              ElementsAre("axis", "command", "inputs", "outcome", "tick"));
  EXPECT_THAT(fields("step 3"), ElementsAre("bench", "ticks", "outcome", "tick"));
  EXPECT_THAT(fields("rate 2"), ElementsAre("bench", "rate", "outcome", "code", "message"));
  EXPECT_THAT(fields("status 1.1"),
              AllOf(testing::Contains("ds402_statusword"), testing::Contains("owner_epoch")));
  EXPECT_THAT(fields("watch 1.1 --count 1"), testing::Contains("position_demand_value"));
}

// Taken in ticks 0 and 7.
TEST_F(ToolInLockStep, SnapshotListShowsTheKeptSnapshots) {
  EXPECT_EQ(call("snapshot list").output, "bench 1 keeps no snapshot\n");
  ASSERT_EQ(call("snapshot take").code, 0);
  ASSERT_EQ(call("step 7").code, 0);
  ASSERT_EQ(call("snapshot take").code, 0);
  EXPECT_THAT(call("snapshot list --bench 1").lines(),
              ElementsAre("bench 1 snapshot 1, taken at tick 0, 2 axes",
                          "bench 1 snapshot 2, taken at tick 7, 2 axes"));
  ASSERT_EQ(call("snapshot drop 1").code, 0);
  EXPECT_THAT(call("snapshot list --json").lines(),
              ElementsAre(R"({"bench":1,"action":"list","snapshot":2,"tick":7})"));
}

TEST_F(ToolInLockStep, ARefusalExitsFiveWithItsCodeAndMeaning) {
  struct Row {
    const char* words;
    const char* code;
  };

  for (const Row& row :
       {Row{"read 1.1 0x9999", "0x06020000"}, Row{"read 1.1 no_such_object", "0x06020000"},
        Row{"read 1.1 0x6041:7", "0x06090011"}, Row{"write 1.1 0x6041 0", "0x06010002"},
        Row{"write 1.1 0x60F2 3", "0x06090030"}, Row{"write 1.1 0x6080 0", "0x06090032"},
        Row{"move 1.1 100", "0x08000022"}, Row{"halt 1.1", "0x08000022"}}) {
    const Finished text = call(row.words);
    EXPECT_EQ(text.code, 5) << row.words;
    EXPECT_THAT(text.errors, HasSubstr(row.code)) << row.words;
    EXPECT_THAT(text.output, IsEmpty()) << row.words;
    const auto objects = json_of(call(std::string(row.words) + " --json"));
    ASSERT_THAT(objects, SizeIs(1)) << row.words;
    EXPECT_EQ(objects[0]["code"], row.code) << row.words;
    EXPECT_FALSE(objects[0]["message"].get<std::string>().empty()) << row.words;
  }
}

// The sub-indices are those of the manual's table. 60F2h accepts three option codes; 6098h accepts
// 0 and the methods of the drive.
TEST_F(ToolInLockStep, ARefusalListsTheSubIndicesAndTheValuesThatAreTaken) {
  EXPECT_THAT(call("read 1.1 0x607D:7").errors, HasSubstr("607Dh has sub-indices 1 and 2"));
  EXPECT_THAT(call("read 1.1 0x6041:7").errors, HasSubstr("6041h has only sub-index 0"));
  EXPECT_THAT(call("write 1.1 0x60F2 3").errors,
              HasSubstr("positioning_option_code accepts 0, 1 or 2"));
  EXPECT_THAT(call("write 1.1 0x6080 0").errors,
              HasSubstr("motor_max_speed_rpm accepts 1 to 4294967295"));
  const std::string methods = "homing_method accepts -4 to 14, 17 to 30, 33 to 35 or 37";
  EXPECT_THAT(call("write 1.1 homing_method 36").errors, HasSubstr(methods));
  ASSERT_EQ(call("enable 1.1").code, 0);
  EXPECT_THAT(call("home 1.1 --method 36").errors, HasSubstr(methods));
}

TEST_F(ToolInLockStep, ReadPrintsEveryObjectEvenWhenOneIsRefused) {
  const Finished finished = call("read 1.1 0x6041 0x9999 no_such 0x6061 --json");
  EXPECT_EQ(finished.code, 5);
  const auto objects = json_of(finished);
  ASSERT_THAT(objects, SizeIs(4));
  EXPECT_TRUE(objects[0].contains("value"));
  EXPECT_EQ(objects[1]["code"], "0x06020000");
  EXPECT_EQ(objects[2]["name"], "no_such");
  EXPECT_EQ(objects[3]["value"], 0);
}

TEST_F(ToolInLockStep, AnUnknownAxisExitsThreeAndListsThePresentOnes) {
  const Finished number = call("status 1.9");
  EXPECT_EQ(number.code, 3);
  EXPECT_THAT(number.errors, AllOf(HasSubstr("1.9"), HasSubstr("bench 1")));
  const Finished name = call("status nobody");
  EXPECT_EQ(name.code, 3);
  EXPECT_THAT(name.errors, AllOf(HasSubstr("nobody"), HasSubstr("bench 1")));
  EXPECT_EQ(call("status 2.1 --timeout 0.2").code, 3);
}

TEST_F(ToolInLockStep, ANotFoundErrorIsOneJsonObject) {
  const Finished finished = call("status 1.9 --json");
  EXPECT_EQ(finished.code, 3);
  const auto objects = json_of(finished);
  ASSERT_THAT(objects, SizeIs(1));
  EXPECT_EQ(objects[0]["outcome"], "not_found");
}

TEST_F(ToolInLockStep, ADirectoryWithoutAScenarioIsRefused) {
  const TemporaryDirectory directory;
  const Finished finished = call("run " + directory.path().string());
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors, HasSubstr("' has no scenario, *.scn"));
}

TEST_F(ToolInLockStep, AClampedMoveExitsOneAndLimitsWithoutEffectAreReported) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  EXPECT_THAT(call("write 1.1 0x607D:2 1000").errors,
              HasSubstr("app_position_limit_switch (3535h)"));
  EXPECT_EQ(call("move 1.1 8000").code, 0) << "3535h is 0";
  ASSERT_EQ(call("move 1.1 0").code, 0);
  EXPECT_THAT(call("write 1.1 0x3535 1").errors, IsEmpty());
  ASSERT_EQ(call("step 1").code, 0);
  const Finished cut = call("move 1.1 8000");
  EXPECT_EQ(cut.code, 1);
  EXPECT_THAT(cut.errors, HasSubstr("user_position_upper_limit (607Dh:2) = 1000"));
  EXPECT_THAT(call("write 1.1 0x607D:1 1000").errors,
              HasSubstr("607Dh:1) = 1000 UU (87.89 deg) is not below user_position_upper_limit "
                        "(607Dh:2) = 1000 UU (87.89 deg)"));
}

TEST_F(ToolInLockStep, AMoveWithoutSpeedIsRefusedAtOnce) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished refused = call("move 1.1 1000 --velocity 0");
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.errors, HasSubstr("profile_velocity (6081h) is 0: the axis cannot move"));
  EXPECT_EQ(call("run -", "refused 0x08000022 move 1.1 1000 --acceleration 0\nmove 1.1 9\n").code,
            0);
  EXPECT_THAT(call("move 1.1 0 --deceleration 9000 --no-wait").errors, HasSubstr("6084h"));
}

TEST_F(ToolInLockStep, ClearingEveryTestInputIsOneLine) {
  ASSERT_EQ(call("disturb 1.1 load_torque 5").code, 0);
  ASSERT_EQ(call("disturb 1.1 home_switch").code, 0);
  EXPECT_THAT(call("disturb 1.1 none").lines(),
              ElementsAre(HasSubstr("1.1 all test inputs cleared, in force at tick ")));
  for (const char* const input : {"test_load_torque", "test_home_input"}) {
    EXPECT_THAT(call(std::string("read 1.1 ") + input).output, HasSubstr(" = 0")) << input;
  }
  const auto objects = json_of(call("disturb 1.1 none --json"));
  ASSERT_THAT(objects, SizeIs(1));
  EXPECT_EQ(objects[0]["inputs"], 13) << "5E00h to 5E0Ch";
}

TEST_F(ToolInLockStep, ADisturbanceForATimeIsClearedAfterIt) {
  ASSERT_EQ(call("disturb 1.1 load_torque -100 --for 20ms").code, 0);
  const auto objects = json_of(call("read 1.1 0x5E00 --json"));
  EXPECT_EQ(objects.at(0)["value"], 0);
  EXPECT_EQ(objects.at(0)["tick"], 20);
}

TEST_F(ToolInLockStep, AStepNeedsABenchNumberWithTwoBenches) {
  const BenchOnWire other("--clock lockstep --bench 2");
  const Finished finished = call("step 1");
  EXPECT_EQ(finished.code, 3);
  EXPECT_THAT(finished.errors,
              AllOf(HasSubstr("bench 1"), HasSubstr("bench 2"), HasSubstr("step 1000 --bench 2")));
  EXPECT_EQ(call("step 1 --bench 2").code, 0);
  EXPECT_THAT(call("rate 1").errors, HasSubstr("rate 2 0.5"));
  EXPECT_THAT(call("record -").errors, HasSubstr("record out.csv 2.1 2.2"));
}

TEST_F(ToolInLockStep, NamesAnAxisAsItWasTyped) {
  EXPECT_THAT(call("halt x").errors, HasSubstr("axis x (1.1) is in Switch on disabled"));
  EXPECT_THAT(call("halt 1.1").errors, HasSubstr("axis 1.1 is in Switch on disabled"));
  EXPECT_THAT(json_of(call("halt x --json")).at(0)["message"].get<std::string>(),
              HasSubstr("axis x (1.1)"));
  EXPECT_THAT(call("enable x").output, testing::StartsWith("x    "));
  EXPECT_THAT(call("read x 0x6061").output, testing::StartsWith("x 0x6061"));
  EXPECT_THAT(call("write x 0x6041 1").errors, HasSubstr("axis x (1.1)"));
}

TEST_F(ToolInLockStep, ARefusalNamesTheNextStepAndAMistypedNameGetsASuggestion) {
  EXPECT_THAT(call("move x 100").errors, HasSubstr("; enable it first: vdrive enable x"));
  ASSERT_EQ(call("disturb 1.1 over_current").code, 0);
  ASSERT_EQ(call("step 2").code, 0);
  EXPECT_THAT(call("enable 1.1").errors, HasSubstr("; reset it first: vdrive reset 1.1"));
  EXPECT_THAT(call("read 1.1 statusward").errors, HasSubstr("(did you mean 'statusword'?)"));
  const BenchOnWire other("--clock lockstep --bench 2 --axes 3");
  EXPECT_THAT(call("status axs3").errors, HasSubstr("'axs3' (did you mean 'axis3'?)"));
}

TEST_F(ToolInLockStep, AFinishedMoveShowsNoSpeed) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  EXPECT_THAT(call("move 1.1 1000").output,
              AllOf(HasSubstr("1000 UU    87.89 deg  0x637"), Not(HasSubstr("UU/s"))));
  EXPECT_THAT(call("move 1.1 0 --no-wait").output, HasSubstr("UU/s"));
}

TEST_F(ToolInLockStep, AScenarioThatFailsLeavesNoDisturbance) {
  const Finished finished = call("run -",
                                 "disturb 1.1 blocked_load\n"
                                 "write y 0x5E00 500\n"
                                 "disturb 1.2 over_current\n"
                                 "disturb 1.2 over_current 0\n"
                                 "expect 1.1 0x6041 0\n");
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("restored: test_blocked_load of 1.1 is 0"),
                                     HasSubstr("restored: test_load_torque of y is 0"),
                                     Not(HasSubstr("test_over_current"))));
  EXPECT_THAT(call("read 1.1 0x5E01").output, HasSubstr("= 0"));
  EXPECT_THAT(call("read 1.2 0x5E00").output, HasSubstr("= 0"));
  EXPECT_EQ(call("run -", "disturb 1.1 blocked_load\n").code, 0);
  EXPECT_THAT(call("read 1.1 0x5E01").output, HasSubstr("= 1"))
      << "the drive time that it prints has passed";
}

TEST_F(ToolInLockStep, StoreWithoutAStateDirectoryNamesIt) {
  const Finished finished = call("store 1.1");
  EXPECT_EQ(finished.code, 5);
  EXPECT_THAT(finished.errors,
              AllOf(HasSubstr("0x08000020"), HasSubstr("start vdrived with --state DIR")));
}

/// A bench in real time, and a directory for a recording.
class Recording : public testing::Test {
 protected:
  [[nodiscard]] std::string file(const std::string& name) const { return directory_.path() / name; }

  [[nodiscard]] static std::vector<std::string> lines_of(const std::string& path) {
    std::ifstream file(path);
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }

  [[nodiscard]] static std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    return cells;
  }

 private:
  BenchOnWire bench_{"--axes 2"};
  TemporaryDirectory directory_;
};

TEST_F(Recording, HasARowForEachAxisAndTickAndCountsMissingOnes) {
  const std::string path = file("both.csv");
  const Finished finished = call("record " + path + " --count 100 --json");
  ASSERT_EQ(finished.code, 0) << finished.errors;
  const std::vector<std::string> lines = lines_of(path);
  ASSERT_THAT(lines, SizeIs(1 + 2 * 100));
  const std::vector<std::string> header = cells_of(lines.front());
  EXPECT_THAT(header, testing::IsSupersetOf({"axis", "name", "tick", "missed", "ds402_statusword",
                                             "load_position_actual_value", "owner"}));
  std::uint64_t last_tick = 0;
  std::uint64_t lost = 0;
  std::uint64_t skipped = 0;
  for (std::size_t row = 1; row < lines.size(); row += 2) {
    const auto first = cells_of(lines[row]);
    const auto second = cells_of(lines[row + 1]);
    ASSERT_THAT(first, SizeIs(header.size()));
    EXPECT_EQ(first[0], "1.1");
    EXPECT_EQ(second[0], "1.2");
    EXPECT_EQ(first[2], second[2]) << "one tick, all axes";
    const std::uint64_t tick = std::stoull(first[2]);
    const std::uint64_t missed = std::stoull(first[3]);
    if (last_tick != 0) {
      ASSERT_GT(tick, last_tick + missed);
      lost += missed;
      skipped += tick - last_tick - 1 - missed;  // the machine was too slow to run these
    }
    last_tick = tick;
  }
  const Json summary = json_of(finished).at(0);
  EXPECT_EQ(summary["samples"], 100);
  EXPECT_EQ(summary["axes"], 2);
  EXPECT_EQ(summary["lost"], lost);
  EXPECT_EQ(summary["skipped"], skipped);
}

TEST_F(Recording, LastsTheGivenDriveTime) {
  const std::string path = file("one.jsonl");
  ASSERT_EQ(call("record " + path + " 1.2 --for 50ms").code, 0);
  std::uint64_t ticks = 0;
  for (const std::string& line : lines_of(path)) {
    const Json row = Json::parse(line);
    EXPECT_EQ(row["axis"], "1.2");
    ticks += ticks == 0 ? 1 : 1 + row["missed"].get<std::uint64_t>();
  }
  // The last tick is within 50 ms of the first; samples lost at the very end are not counted.
  EXPECT_LE(ticks, 50U);
  EXPECT_GE(ticks, 40U);
}

TEST_F(Recording, NamesAnUnwritablePath) {
  const Finished finished = call("record " + file("no/such/folder.csv") + " 1.1");
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("no/such/folder.csv"), HasSubstr("No such file"),
                                     Not(HasSubstr("recorded"))));
  EXPECT_THAT(call("record - 1.1 --count 1").errors, HasSubstr("recorded 1 sample of 1 axis,"));
}

TEST_F(ToolInLockStep, AScenarioFromStandardInputRunsAsOneSession) {
  const Finished finished = call("run -",
                                 "enable 1.1\r\n"
                                 "write 1.1 0x607A 100   # a comment\r\n"
                                 "\r\n"
                                 "write 1.1 0x6060 1\r\n"
                                 "step 1\r\n"
                                 "write 1.1 0x6040 0x3F\r\n"
                                 "expect 1.1 0x6041 0x1637 --within 1s\r\n"
                                 "refused 0x06010002 write 1.1 0x6041 1\r\n");
  EXPECT_EQ(finished.code, 0) << finished.errors << finished.output;
  EXPECT_THAT(finished.output, HasSubstr("passed"));
}

// Errors that end a scenario before its first line, with the exit code: 2 usage, 3 not found.
TEST_F(ToolInLockStep, AReportNamesTheReasonWhyAScenarioDidNotBegin) {
  const TemporaryDirectory directory;
  const auto junit = directory.path() / "out.xml";
  const auto report_of = [&](const std::string& lines, int code) {
    EXPECT_EQ(call({"run", "-", "--junit", junit.string()}, lines).code, code);
    std::ifstream file(junit);
    std::stringstream xml;
    xml << file.rdbuf();
    return xml.str();
  };
  EXPECT_THAT(report_of("enabel 1.1\n", 2),
              AllOf(HasSubstr("errors=\"1\""), HasSubstr("&lt;stdin&gt;:1:"), HasSubstr("enabel")));
  EXPECT_THAT(report_of("enable 1.77\n", 3),
              AllOf(HasSubstr("errors=\"1\""), HasSubstr("<error message="), HasSubstr("1.77")));
}

TEST_F(ToolInLockStep, AnUnwritableReportIsRefusedBeforeTheFirstCommand) {
  const Finished finished = call({"run", "-", "--junit", "/nonexistent/x.xml"}, "enable 1.1\n");
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors,
              AllOf(HasSubstr("/nonexistent/x.xml"), HasSubstr("No such file or directory")));
  EXPECT_EQ(json_of(call("status 1.1 --json")).at(0)["ds402_statusword"], 0x250) << "not enabled";
}

TEST_F(ToolInLockStep, AnUnexpectedRefusalEndsTheScenario) {
  const Finished other = call("run -", "refused 0x06010002 write 1.1 0x60F2 3\n");
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.errors, AllOf(HasSubstr("0x06010002"), HasSubstr("0x06090030")));
  EXPECT_EQ(call("run -", "refused 0x06010002 write 1.1 0x60F2 1\n").code, 1) << "accepted";
  EXPECT_EQ(call("run -", "write 1.1 0x60F2 3\n").code, 1);
}

TEST_F(ToolInLockStep, AScenarioPrintsItsLinesInJson) {
  const Finished finished =
      call("run - --json", "wait 3ms\nread 1.1 0x6041\nexpect 1.1 0x6041 0\n");
  EXPECT_EQ(finished.code, 1);
  const auto objects = json_of(finished);
  ASSERT_THAT(objects, SizeIs(5));
  EXPECT_THAT(keys(objects[0]), ElementsAre("file", "line", "command", "outcome", "seconds"));
  EXPECT_EQ(objects[1]["tick"], 3) << "what a word answers comes before its line";
  EXPECT_THAT(keys(objects[3]),
              ElementsAre("file", "line", "command", "outcome", "message", "expected", "actual",
                          "tick", "type", "details", "advice", "seconds"));
  EXPECT_EQ(objects[3]["actual"], 0x250);
  EXPECT_EQ(objects[3]["type"], "expectation");
  EXPECT_EQ(objects[4]["passed"], false);
  EXPECT_EQ(objects[4]["lines"], 3);
  EXPECT_EQ(objects[4]["done"], 3);
}

TEST_F(ToolInLockStep, ThroughoutDetectsASingleDifferentTick) {
  const Finished finished = call("run -",
                                 "enable 1.1\n"
                                 "write 1.1 0x6060 1\n"
                                 "step 1\n"
                                 "write 1.1 0x607A 0\n"
                                 "write 1.1 0x6040 0x3F\n"  // a move to the current position: 20 ms
                                 "expect 1.1 0x6041 0x1237 --throughout 30ms\n");
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, HasSubstr("actual 0x1637"));
}

TEST_F(ToolInLockStep, AWatchOfSeveralSamplesEndsWhereNobodySteps) {
  const auto says_how_to_step =
      testing::AllOf(HasSubstr("no tick has passed within 200 ms; bench 1 is in lock-step: "),
                     HasSubstr("'vdrive step'"), HasSubstr("watch --count 1"));
  const Finished alone = call("watch 1.1 --count 2 --timeout 0.2");
  EXPECT_EQ(alone.code, 4);
  EXPECT_THAT(alone.output, HasSubstr("1.1")) << "it shows the present state first";
  EXPECT_THAT(alone.errors, says_how_to_step);
  const Finished in_scenario = call("run -", "watch 1.1 --count 2 --timeout 0.2\n");
  EXPECT_EQ(in_scenario.code, 1);
  EXPECT_THAT(in_scenario.errors, says_how_to_step);
}

TEST(ToolInRealtime, AWatchOfABenchThatIsPausedSaysHowTimePasses) {
  const BenchOnWire bench("--clock realtime --rate 0");
  const Finished finished = call("watch 1.1 --count 2 --timeout 0.2");
  EXPECT_EQ(finished.code, 4);
  EXPECT_THAT(finished.errors, HasSubstr("no tick has passed within 200 ms; bench 1 is paused: "
                                         "'vdrive rate 1' continues it"));
}

TEST(ToolInRealtime, ShowsABenchThatIsPaused) {
  const BenchOnWire bench("--clock realtime --rate 0");
  EXPECT_EQ(call("list").code, 0);
  EXPECT_EQ(json_of(call("status 1.1 --json")).at(0)["ds402_statusword"], 0x250);
  EXPECT_EQ(json_of(call("watch 1.1 --json --count 1")).at(0)["state"], "Switch on disabled");
  EXPECT_EQ(call("read 1.1 0x6041").code, 0);
}

TEST(ToolInRealtime, PausesAndContinues) {
  const BenchOnWire bench("--clock realtime");
  const Finished paused = call("rate 0 --json");
  EXPECT_EQ(paused.code, 0) << paused.errors;
  ASSERT_THAT(json_of(paused), SizeIs(1));
  EXPECT_THAT(keys(json_of(paused).front()), ElementsAre("bench", "rate", "outcome", "tick"));
  const Finished enable = call("enable 1.1");
  EXPECT_EQ(enable.code, 1) << "at once, not at the end of drive time that never comes";
  EXPECT_THAT(enable.errors, HasSubstr("bench 1 is paused: rate 0"));
  EXPECT_LT(enable.duration, 10s);
  EXPECT_THAT(call("list").output, HasSubstr(" us, paused, "));
  EXPECT_EQ(call("rate").output, "bench 1 realtime rate 0\n");
  EXPECT_EQ(call("rate 1 0.5").output.substr(0, 21), "bench 1 rate 0.5 tick");
  EXPECT_THAT(call("list").output, HasSubstr(" us, rate 0.5, "));
  EXPECT_EQ(call("rate --json").output, "{\"bench\":1,\"clock\":\"realtime\",\"rate\":0.5}\n");
  const Finished enabled = call("enable 1.1");
  EXPECT_EQ(enabled.code, 0) << enabled.errors;
}

TEST(ToolInRealtime, ARateOutOfRangeIsRefusedAndTextIsAUsageError) {
  const BenchOnWire bench("--clock realtime");
  const Finished refused = call("rate 101 --json");
  EXPECT_EQ(refused.code, 5);
  ASSERT_THAT(json_of(refused), SizeIs(1));
  EXPECT_EQ(json_of(refused).front()["outcome"], "refused");
  EXPECT_EQ(json_of(refused).front()["code"], "0x00000018");
  EXPECT_EQ(call("rate -1").code, 5);
  EXPECT_EQ(call("rate fast").code, 2);
  EXPECT_EQ(call("rate nan").code, 2);
  EXPECT_EQ(call("rate 1 2 3").code, 2);
}

TEST(ToolInRealtime, ARefusedStepIsOneJsonObject) {
  const BenchOnWire bench("--clock realtime");
  const Finished refused = call("step 1 --json");
  EXPECT_EQ(refused.code, 5);
  ASSERT_THAT(json_of(refused), SizeIs(1));
  EXPECT_THAT(keys(json_of(refused).front()),
              ElementsAre("bench", "ticks", "outcome", "code", "message"));
}

TEST(ToolInRealtime, RunsAScenarioOfWaitsOnly) {
  const BenchOnWire bench("--clock realtime");
  const Finished finished = call("run -",
                                 "enable 1.1\n"
                                 "write 1.1 0x6060 1\n"
                                 "wait 20ms\n"
                                 "write 1.1 0x607A 2000\n"
                                 "write 1.1 0x6081 5000\n"
                                 "write 1.1 0x6040 0x3F\n"
                                 "expect 1.1 0x6041 0x1237 --within 50ms\n"
                                 "expect 1.1 0x6041 0x1637 --within 2s\n"
                                 "expect 1.1 0x6062 2000\n"
                                 "expect 1.1 0x607A 2000 --within 1ms\n"
                                 "disable 1.1\n"
                                 "refused 14 step 1\n");
  EXPECT_EQ(finished.code, 0) << finished.errors << finished.output;
}

TEST(ToolInRealtime, ThroughoutNeedsAnObjectOfTheStatusStream) {
  const BenchOnWire bench("--clock realtime");
  const Finished finished = call("run -", "expect 1.1 0x607A 0 --throughout 5ms\n");
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, HasSubstr("status stream"));
}

}  // namespace
}  // namespace vdrive::test
