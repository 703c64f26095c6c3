// SPDX-License-Identifier: Apache-2.0
// vdrive judge without a network: reports, exceptions and exit codes.
#include "base/usage_error.hpp"
#include "command_table.hpp"
#include "judge/rule.hpp"
#include "output/judge_reports.hpp"
#include "support/temporary_directory.hpp"
#include "tool.hpp"
#include "tool/call.hpp"
#include "tool/json_lines.hpp"
#include "vdrive/text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using test::Finished;
using test::json_of;
using test::keys;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

const std::string kLog = VDRIVE_SOURCE_DIR "/docs/guides/one_move.candump";

Finished judge(std::vector<std::string> arguments, const std::string& input = "") {
  arguments.insert(arguments.begin(), "judge");
  return test::captured(
      [&arguments] {
        return static_cast<int>(run_tool(arguments));
      },
      input);
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class JudgeCommandTest : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return (directory.path() / name).string();
  }

  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
  }

  test::TemporaryDirectory directory;
};

TEST_F(JudgeCommandTest, TellsEachFindingOnceWorstFirstWithTheTableAroundIt) {
  const Finished done = judge({kLog});
  EXPECT_EQ(done.code, 1);
  EXPECT_THAT(done.output, StartsWith(kLog + ": 3 findings on 1 axis: 2 errors, 1 warning"));
  const std::size_t first = done.output.find("error handshake-2 on node 5: Bit 4 stays 1");
  const std::size_t second = done.output.find("error pdo-1 on node 5");
  const std::size_t third = done.output.find("warning state-2 on node 5");
  ASSERT_NE(third, std::string::npos);
  EXPECT_LT(first, second);
  EXPECT_LT(second, third);
  EXPECT_THAT(done.output,
              HasSubstr("6040h = 0x001F has bit 4 set, like the previous controlword"));
  EXPECT_THAT(done.output, HasSubstr("0x1237 Operation enabled, set-point acknowledge"));
  EXPECT_THAT(done.output, HasSubstr("  > "));
  EXPECT_THAT(done.output, HasSubstr("not judged:\n"));
  EXPECT_THAT(done.output,
              HasSubstr("RPDO 1 of node 5 is assumed to map 6040h, the default of CiA 402"));
}

TEST_F(JudgeCommandTest, ExitsByTheSeverityThatItIsToldToFailOn) {
  const std::string warnings = file("warnings.yaml",
                                    "- {rule: handshake-2, reason: known}\n"
                                    "- {rule: pdo-1, axis: node 5, reason: known}\n");
  EXPECT_EQ(judge({kLog}).code, 1);
  EXPECT_EQ(judge({kLog, "--fail-on", "never"}).code, 0);
  EXPECT_EQ(judge({kLog, "--exceptions", warnings}).code, 0) << "a warning is left";
  EXPECT_EQ(judge({kLog, "--exceptions", warnings, "--fail-on", "warning"}).code, 1);
  EXPECT_EQ(judge({kLog, "--exceptions", warnings, "--fail-on", "advice"}).code, 1);
  EXPECT_EQ(judge({kLog, "--node", "6", "--fail-on", "advice"}).code, 0);
}

TEST_F(JudgeCommandTest, RefusesWhatItCannotUnderstand) {
  EXPECT_EQ(judge({}).code, 2);
  EXPECT_EQ(judge({kLog, "--rules"}).code, 2);
  EXPECT_EQ(judge({kLog, "--node", "128"}).code, 2);
  EXPECT_EQ(judge({kLog, "--node", "0"}).code, 2);
  EXPECT_EQ(judge({kLog, "--fail-on", "much"}).code, 2);
  EXPECT_EQ(judge({kLog, "--eds", path("none.eds")}).code, 2);
  EXPECT_EQ(judge({kLog, "--eds", file("empty.eds", "[FileInfo]\n")}).code, 2);
  EXPECT_EQ(judge({kLog, "--html", path("no/such/folder.html")}).code, 2);
}

TEST_F(JudgeCommandTest, HasAnExitCodeForALogThatCannotBeRead) {
  for (const std::string& log :
       {path("none.candump"), file("text.candump", "no frame\n"), file("empty.candump", "")}) {
    const Finished done = judge({log, "--json"});
    EXPECT_EQ(done.code, 7) << log;
    EXPECT_THAT(done.errors, HasSubstr("cannot be judged: "));
    const auto objects = json_of(done);
    ASSERT_THAT(objects, SizeIs(1));
    EXPECT_EQ(objects.front().at("outcome"), "unreadable");
  }
}

TEST_F(JudgeCommandTest, RefusesAFolder) {
  const Finished done = judge({directory.path().string()});
  EXPECT_EQ(done.code, 7);
  EXPECT_THAT(done.errors, HasSubstr("Is a directory"));
}

TEST_F(JudgeCommandTest, ReadsStandardInput) {
  const Finished done = judge({"-"}, content_of(kLog));
  EXPECT_EQ(done.code, 1);
  EXPECT_THAT(done.output, StartsWith("-: 3 findings"));
}

TEST_F(JudgeCommandTest, RefusesExceptionsWithoutAReasonOrARule) {
  const auto refusal = [&](const std::string& text) {
    const Finished done = judge({kLog, "--exceptions", file("exceptions.yaml", text)});
    EXPECT_EQ(done.code, 2) << text;
    return done.errors;
  };
  EXPECT_THAT(refusal("- rule: handshake-2\n"),
              AllOf(HasSubstr("exceptions.yaml:1"), HasSubstr("has no reason")));
  EXPECT_THAT(refusal("- rule: handshake-2\n  reason: ' '\n"), HasSubstr("has no reason"));
  EXPECT_THAT(refusal("- reason: known\n"), HasSubstr("the key rule is missing"));
  EXPECT_THAT(refusal("- rule: handshake-99\n  reason: known\n"),
              AllOf(HasSubstr("is not a rule"), HasSubstr("did you mean 'handshake-")));
  EXPECT_THAT(refusal("- rule: handshake-2\n  reason: known\n  until: June\n"), HasSubstr("until"));
  EXPECT_THAT(refusal("rule: handshake-2\n"), HasSubstr("exceptions.yaml"));
}

TEST_F(JudgeCommandTest, TellsExceptionsWithTheirReasonAndThoseThatCoverNothing) {
  const std::string exceptions = file("exceptions.yaml",
                                      "- rule: handshake-2\n"
                                      "  axis: node 5\n"
                                      "  reason: shown to visitors\n"
                                      "- rule: pdo-1\n"
                                      "  axis: node 6\n"
                                      "  reason: of another machine\n"
                                      "- rule: sync-1\n"
                                      "  reason: old\n");
  const Finished done = judge({kLog, "--exceptions", exceptions});
  EXPECT_THAT(done.output,
              HasSubstr("excepted:\n  handshake-2 on node 5, 2 times: shown to visitors\n"));
  EXPECT_THAT(done.output, HasSubstr("unused exceptions:\n  " + exceptions +
                                     ":4: pdo-1 on node 6\n  " + exceptions + ":7: sync-1\n"));
  EXPECT_THAT(done.output, HasSubstr("error pdo-1 on node 5"));
  EXPECT_THAT(done.output, Not(HasSubstr("error handshake-2")));
}

TEST_F(JudgeCommandTest, PrintsTheDocumentedJson) {
  const Finished done = judge({kLog, "--json"});
  const auto objects = json_of(done);
  ASSERT_THAT(objects, SizeIs(4));
  EXPECT_THAT(keys(objects[0]),
              ElementsAre("rule", "severity", "axis", "title", "count", "first", "last", "happened",
                          "expected", "clause", "remedy", "lines"));
  EXPECT_THAT(keys(objects[0].at("first")), ElementsAre("time_ns", "tick", "line"));
  EXPECT_THAT(keys(objects[0].at("lines").at(0)),
              ElementsAre("time_ns", "by", "what", "controlword", "statusword", "controlword_text",
                          "statusword_text", "mode", "target", "actual", "waits_for", "is_place"));
  EXPECT_EQ(objects[0].at("rule"), "handshake-2");
  EXPECT_EQ(objects[0].at("count"), 2);
  EXPECT_EQ(std::ranges::count(objects[0].at("lines"), true,
                               [](const auto& line) {
                                 return line.at("is_place").template get<bool>();
                               }),
            1);
  EXPECT_THAT(keys(objects[3]),
              ElementsAre("file", "errors", "warnings", "advice", "axes", "records", "duration_ns",
                          "excepted", "unused_exceptions", "not_judged", "notes"));
  EXPECT_EQ(objects[3].at("errors"), 2);
  EXPECT_EQ(objects[3].at("warnings"), 1);
}

TEST_F(JudgeCommandTest, WritesACaseOfJunitForEachRule) {
  const std::string report = path("junit.xml");
  judge({kLog, "--junit", report});
  const std::vector<JunitSuite> suites = read_junit(content_of(report)).suites;
  ASSERT_THAT(suites, SizeIs(1));
  EXPECT_THAT(suites.front().cases, SizeIs(judge::rules().size()));
  std::vector<std::string> failures;
  std::vector<std::string> skipped;
  for (const JunitCase& test : suites.front().cases) {
    const std::string rule = test.name.substr(0, test.name.find(' '));
    if (test.failure) failures.push_back(rule);
    if (test.is_skipped) skipped.push_back(rule);
  }
  EXPECT_THAT(failures, ElementsAre("handshake-2", "pdo-1")) << "warnings do not fail by default";
  EXPECT_THAT(skipped,
              AllOf(Contains("writers-2"), Contains("motion-8"), Not(Contains("state-1"))));
}

TEST_F(JudgeCommandTest, WritesSarifWithLinesOfTheLog) {
  const std::string report = path("report.sarif");
  const std::string exceptions = file("exceptions.yaml", "- {rule: pdo-1, reason: known}\n");
  judge({kLog, "--sarif", report, "--exceptions", exceptions});
  const Json sarif = Json::parse(content_of(report));
  EXPECT_EQ(sarif.at("version"), "2.1.0");
  const Json& run = sarif.at("runs").at(0);
  const Json& rules = run.at("tool").at("driver").at("rules");
  EXPECT_EQ(rules.size(), judge::rules().size());
  const Json& results = run.at("results");
  ASSERT_EQ(results.size(), 3U);
  for (const Json& result : results) {
    EXPECT_EQ(rules.at(result.at("ruleIndex").get<std::size_t>()).at("id"), result.at("ruleId"));
    const Json& place = result.at("locations").at(0).at("physicalLocation");
    EXPECT_EQ(place.at("artifactLocation").at("uri"), kLog);
    EXPECT_GT(place.at("region").at("startLine"), 0);
  }
  EXPECT_EQ(results.at(0).at("level"), "error");
  EXPECT_EQ(results.at(1).at("level"), "warning");
  EXPECT_EQ(results.at(2).at("suppressions").at(0).at("justification"), "known");
}

TEST_F(JudgeCommandTest, WritesAPageThatNeedsNoOtherFile) {
  const std::string report = path("report.html");
  judge({kLog, "--html", report});
  const std::string page = content_of(report);
  EXPECT_THAT(page, StartsWith("<!doctype html>"));
  EXPECT_THAT(page, AllOf(HasSubstr("id=\"handshake-2-5\""), HasSubstr("href=\"#handshake-2-5\""),
                          HasSubstr("<svg "), HasSubstr("actual 6064h"), HasSubstr("target 607Ah"),
                          HasSubstr("class=\"place\""), HasSubstr("Not judged")));
  // The SVG namespace is only a name; no page is loaded from it.
  std::string rest = page;
  const std::string name_space = "xmlns=\"http://www.w3.org/2000/svg\"";
  for (std::size_t at = 0; (at = rest.find(name_space)) != std::string::npos;)
    rest.erase(at, name_space.size());
  for (const char* const other :
       {"http:", "https:", "src=", "<script", "<link", "@import", "url("}) {
    EXPECT_THAT(rest, Not(HasSubstr(other)));
  }
}

TEST_F(JudgeCommandTest, EscapesWhatALogNames) {
  const std::string log = file("a<b&c.candump", content_of(kLog));
  judge({log, "--html", path("report.html"), "--junit", path("junit.xml")});
  EXPECT_THAT(content_of(path("report.html")),
              AllOf(HasSubstr("a&lt;b&amp;c"), Not(HasSubstr("a<b"))));
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.LoadFile(path("junit.xml").c_str()), tinyxml2::XML_SUCCESS);
}

TEST_F(JudgeCommandTest, WritesAPageOfTextThatNoFileNameBreaks) {
  const std::string log = file("a\x01\xFF.candump", content_of(kLog));
  judge({log, "--html", path("report.html")});
  const std::string page = content_of(path("report.html"));
  EXPECT_TRUE(is_utf8(page));
  EXPECT_THAT(page, AllOf(HasSubstr("a\\x01\\xFF.candump"), Not(HasSubstr("\x01"))));
}

TEST_F(JudgeCommandTest, WritesAReasonOfAnyLengthInItsPage) {
  const std::string reason(1'000, 'r');
  const std::string exceptions =
      file("exceptions.yaml", "- {rule: pdo-1, reason: " + reason + "}\n");
  judge({kLog, "--html", path("report.html"), "--exceptions", exceptions});
  EXPECT_THAT(content_of(path("report.html")), HasSubstr(reason));
}

TEST_F(JudgeCommandTest, FailsWhenAReportCannotBeWritten) {
  for (const char* const option : {"--junit", "--sarif", "--html"}) {
    const Finished done = judge({kLog, option, "/dev/full", "--fail-on", "never"});
    EXPECT_EQ(done.code, 1) << option;
    EXPECT_THAT(done.errors, HasSubstr("cannot write the report '/dev/full'"));
  }
}

TEST_F(JudgeCommandTest, ListsTheRulesAsTheReferenceHasThem) {
  const std::string page = content_of(VDRIVE_SOURCE_DIR "/docs/reference/judge-rules.md");
  const Finished done = judge({"--rules"});
  EXPECT_EQ(done.code, 0);
  EXPECT_TRUE(done.output == page)
      << "write it with: vdrive judge --rules > docs/reference/judge-rules.md";
  EXPECT_THAT(json_of(judge({"--rules", "--json"})), SizeIs(judge::rules().size()));
}

// The guide shows the output of the command.
TEST_F(JudgeCommandTest, PrintsWhatTheGuideShows) {
  const std::string guide = content_of(VDRIVE_SOURCE_DIR "/docs/guides/judging.md");
  const std::string begin = "```\n$ vdrive judge docs/guides/one_move.candump\n";
  const std::size_t at = guide.find(begin);
  ASSERT_NE(at, std::string::npos);
  const std::string shown =
      guide.substr(at + begin.size(), guide.find("```", at + begin.size()) - at - begin.size());
  std::string printed = judge({kLog}).output;
  printed.replace(0, kLog.size(), "docs/guides/one_move.candump");
  std::size_t next = 0;
  std::size_t lines = 0;
  for (std::size_t from = 0; from < shown.size(); ++lines) {
    const std::size_t end = shown.find('\n', from);
    const std::string line = shown.substr(from, end - from);
    from = end + 1;
    if (line == "...") continue;
    const std::size_t found = printed.find(line + "\n", next);
    ASSERT_NE(found, std::string::npos) << line;
    next = found;
  }
  EXPECT_GT(lines, 10U);
}

}  // namespace
}  // namespace vdrive::tool
