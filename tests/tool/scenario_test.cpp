// SPDX-License-Identifier: Apache-2.0
// Scenario files: lines, comments, quotes, errors with file and line; and the JUnit report.
#include "language/scenario.hpp"

#include "base/usage_error.hpp"
#include "command_table.hpp"
#include "commands/expect.hpp"
#include "output/junit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace vdrive::tool {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;
using testing::ThrowsMessage;

Scenario scenario_of(const std::string& text) {
  std::istringstream input(text);
  return parse_scenario(commands(), input, "test.scn");
}

TEST(ScenarioLine, IsSplitAtBlanks) {
  EXPECT_THAT(split_words("  move  1.1\t-500 "), ElementsAre("move", "1.1", "-500"));
  EXPECT_THAT(split_words(""), IsEmpty());
}

TEST(ScenarioLine, EndsAtAComment) {
  EXPECT_THAT(split_words("# all of it"), IsEmpty());
  EXPECT_THAT(split_words("wait 5ms # some"), ElementsAre("wait", "5ms"));
  EXPECT_THAT(split_words("wait 5ms#some"), ElementsAre("wait", "5ms"));
}

TEST(ScenarioLine, KeepsQuotedBlanksAndHashes) {
  EXPECT_THAT(split_words("enable 'left # axis'"), ElementsAre("enable", "left # axis"));
  EXPECT_THAT(split_words("enable \"it's\""), ElementsAre("enable", "it's"));
  EXPECT_THAT(split_words("enable ''"), ElementsAre("enable", ""));
}

TEST(ScenarioLine, RefusesAQuoteThatDoesNotEnd) {
  EXPECT_THROW((void)split_words("enable 'x"), UsageError);
}

TEST(ScenarioFile, SkipsBlankLinesAndCountsThem) {
  const Scenario scenario = scenario_of("# title\n\nenable 1.1   # go\n  \nwait 1s\n");
  ASSERT_EQ(scenario.lines.size(), 2U);
  EXPECT_EQ(scenario.lines[0].number, 3U);
  EXPECT_EQ(scenario.lines[0].text, "enable 1.1");
  EXPECT_EQ(scenario.lines[1].number, 5U);
}

TEST(ScenarioFile, AcceptsCarriageReturnsAByteOrderMarkAndAMissingLastLineEnd) {
  const Scenario scenario = scenario_of(
      "\xEF\xBB\xBF"
      "enable 1.1\r\n\r\nwait 1s");
  ASSERT_EQ(scenario.lines.size(), 2U);
  EXPECT_EQ(scenario.lines[0].text, "enable 1.1");
  EXPECT_EQ(scenario.lines[1].number, 3U);
}

TEST(ScenarioFile, NamesFileAndLineOfAMistake) {
  EXPECT_THAT(
      [] {
        (void)scenario_of("wait 1s\n\ndance\n");
      },
      ThrowsMessage<UsageError>(StartsWith("test.scn:3: ")));
  EXPECT_THAT(
      [] {
        (void)scenario_of("write 1.1 0x6060 300\n");
      },
      ThrowsMessage<UsageError>(HasSubstr("-128 to 127")));
}

std::string mistake_in(const std::string& text) {
  try {
    (void)scenario_of(text);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "none";
}

TEST(ScenarioFile, NamesAnObjectThatDoesNotExistAndAValueOutOfItsRange) {
  EXPECT_THAT(mistake_in("wait 1s\nread 1.1 0x6041 no_such_object\n"),
              StartsWith("test.scn:2: 'no_such_object' is not an object"));
  EXPECT_THAT(mistake_in("write 1.1 0x9999 0\n"), StartsWith("test.scn:1: '0x9999' is not"));
  EXPECT_THAT(mistake_in("expect 1.1 0x607D:7 0\n"), StartsWith("test.scn:1: '0x607D:7' is not"));
  EXPECT_EQ(mistake_in("write 1.1 0x6041 0\n"), "test.scn:1: '0x6041' is read-only");
  EXPECT_EQ(mistake_in("write 1.1 0x6080 0\n"),
            "test.scn:1: 0 is out of range: motor_max_speed_rpm has 1 to 4294967295");
  EXPECT_EQ(mistake_in("expect 1.1 0x3535 2 --within 1s\n"),
            "test.scn:1: 2 is never reached: app_position_limit_switch has 0 to 1");
  EXPECT_EQ(mistake_in("expect 1.1 0x3535 2 --tolerance 1\n"), "none");
  EXPECT_EQ(mistake_in("disturb 1.1 blocked_load 2\n"),
            "test.scn:1: 2 is out of range: test_blocked_load has 0 to 1");
}

// Each line is a different kind of mistake.
TEST(ScenarioFile, NamesEveryMistakeWithFileAndLine) {
  const std::vector<std::string> wrong{"dance",
                                       "write 1.1 0x6060 300",
                                       "read 1.1 no_such_object",
                                       "write 1.1 0x6041 0",
                                       "expect 1.1 position => 100",
                                       "wait 1.1 target_reachd",
                                       "move 1.1 90mm/s",
                                       "enable 'x",
                                       "let = 5",
                                       "move ${unknown} 5",
                                       "finally now"};
  std::string text = "enable 1.1\n";
  for (const std::string& line : wrong) text += line + "\n\nwait 1ms\n";
  const std::string mistakes = mistake_in(text);
  std::istringstream lines(mistakes);
  std::size_t number = 2;
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count, number += 3) {
    EXPECT_THAT(line, StartsWith("test.scn:" + std::to_string(number) + ": "));
  }
  EXPECT_EQ(count, wrong.size()) << mistakes;
}

TEST(ScenarioFile, NamesAHundredMistakesAtMost) {
  std::string text;
  for (int i = 0; i < 1'000; ++i) text += "dance\n";
  const std::string mistakes = mistake_in(text);
  EXPECT_THAT(mistakes, HasSubstr("\ntest.scn:100: "));
  EXPECT_THAT(mistakes, Not(HasSubstr("test.scn:101: ")));
  EXPECT_THAT(mistakes, testing::EndsWith("\nstopped after 100 mistakes"));
}

TEST(ScenarioFile, AcceptsAnyObjectWhereARefusalIsExpected) {
  EXPECT_EQ(mistake_in("refused 0x06020000 read 1.1 no_such_object\n"), "none");
  EXPECT_EQ(mistake_in("refused 0x06010002 write 1.1 0x6041 0\n"), "none");
  EXPECT_EQ(mistake_in("refused 0x06090032 write 1.1 0x6080 0\n"), "none");
}

TEST(ScenarioFile, OfBinaryDataIsRefused) {
  std::string garbage;
  for (int byte = 255; byte >= 0; --byte) garbage += static_cast<char>(byte);
  EXPECT_THROW((void)scenario_of(garbage), UsageError);
  EXPECT_THROW((void)scenario_of(std::string(1U << 20U, 'x')), UsageError);
}

// "wait" in UTF-16, with a byte order mark.
TEST(ScenarioFile, InUtf16IsRefusedAsSuch) {
  EXPECT_THAT(
      [] {
        (void)scenario_of(std::string("\xFF\xFEw\0a\0i\0t\0", 10));
      },
      ThrowsMessage<UsageError>("test.scn: is encoded in UTF-16 or UTF-32; it must be UTF-8"));
}

TEST(ScenarioFile, NamesAComparisonThatIsNeverTrue) {
  EXPECT_EQ(mistake_in("expect 1.1 position > 100\nexpect 1.1 0x3535 != 7\n"), "none");
  // 6041h is an UNSIGNED16.
  EXPECT_EQ(mistake_in("expect 1.1 statusword > 65535\n"),
            "test.scn:1: > 65535 is never reached: ds402_statusword has 0 to 65535");
  EXPECT_EQ(mistake_in("expect 1.1 statusword < 0\n"),
            "test.scn:1: < 0 is never reached: ds402_statusword has 0 to 65535");
  EXPECT_EQ(mistake_in("expect 1.1 statusword <= 0\n"), "none");
  EXPECT_THAT(mistake_in("expect 1.1 position => 100\n"), HasSubstr("'=>' is not a comparison"));
  EXPECT_THAT(mistake_in("expect 1.1 position > 100 --tolerance 1\n"),
              HasSubstr("go with == and !=, not with >"));
  EXPECT_THAT(mistake_in("wait 1.1 target_reachd\n"), HasSubstr("did you mean 'target_reached'?"));
}

bool holds(const std::string& comparison, std::int64_t actual) {
  const Scenario scenario = scenario_of("expect 1.1 position " + comparison + "\n");
  return std::any_cast<ExpectCommand>(scenario.lines.front().command.arguments)
      .expectation.accepts(actual);
}

TEST(ScenarioFile, ComparesByItsOperator) {
  struct Row {
    const char* sign;
    bool below, equal, above;
  };

  for (const Row& row :
       {Row{"==", false, true, false}, Row{"!=", true, false, true}, Row{"<", true, false, false},
        Row{"<=", true, true, false}, Row{">", false, false, true}, Row{">=", false, true, true}}) {
    const std::string comparison = std::string(row.sign) + " -5";
    EXPECT_EQ(holds(comparison, -6), row.below) << row.sign;
    EXPECT_EQ(holds(comparison, -5), row.equal) << row.sign;
    EXPECT_EQ(holds(comparison, -4), row.above) << row.sign;
  }
  EXPECT_TRUE(holds("!= 100 --tolerance 2", 103));
  EXPECT_FALSE(holds("!= 100 --tolerance 2", 102));
}

std::vector<std::string> texts_of(const Scenario& scenario) {
  std::vector<std::string> texts;
  for (const ScenarioLine& line : scenario.lines) texts.push_back(line.text);
  return texts;
}

TEST(ScenarioVariable, IsReplacedByItsValue) {
  EXPECT_THAT(texts_of(scenario_of("let a = 1.1\nenable ${a}  # ${b}\ndisable '${a}'\n")),
              ElementsAre("enable 1.1", "disable '1.1'"));
}

TEST(ScenarioVariable, OfTheCommandLineTakesPrecedence) {
  std::istringstream input(
      "let axis = 7.1   # ${comment}\n"
      "let zeros=00\n"
      "let target=1${zeros}\n"
      "let ramps = --velocity 500 --acceleration 100\n"
      "move ${axis} ${target} ${ramps}\n"
      "wait ${time}ms\n");
  const Scenario scenario =
      parse_scenario(commands(), input, "test.scn", settings_of({"axis=1.2", "time = 20"}));
  EXPECT_THAT(texts_of(scenario),
              ElementsAre("move 1.2 100 --velocity 500 --acceleration 100", "wait 20ms"));
  EXPECT_THAT(scenario.variables, ElementsAre("axis", "ramps", "target", "time", "zeros"));
}

TEST(ScenarioVariable, IsNamedWhenItCannotBeUsed) {
  EXPECT_THAT(mistake_in("let speed = 5\nwait ${sped}ms\n"),
              AllOf(StartsWith("test.scn:2: "), HasSubstr("did you mean 'speed'?"),
                    HasSubstr("--set sped=VALUE")));
  EXPECT_THAT(mistake_in("let speed 5\n"), HasSubstr("let speed = 500"));
  EXPECT_THAT(mistake_in("let 5th = 5\n"), HasSubstr("'5th' is not a name"));
  EXPECT_THAT(mistake_in("let a =\n"), HasSubstr("has no value"));
  EXPECT_THAT(mistake_in("let a = 'x'\n"), HasSubstr("must not contain"));
  EXPECT_THAT(mistake_in("let a = 1\nlet a = 2\n"), HasSubstr("has a value already"));
  EXPECT_THAT(mistake_in("wait ${a\n"), HasSubstr("no }"));
  EXPECT_THROW((void)settings_of({"axis"}), UsageError);
  EXPECT_THROW((void)settings_of({"axis=1", "axis=2"}), UsageError);
}

TEST(ScenarioFile, HasFinalLinesBelowFinally) {
  const Scenario scenario = scenario_of("enable 1.1\nfinally\ndisable 1.1\n");
  ASSERT_EQ(scenario.lines.size(), 2U);
  EXPECT_FALSE(scenario.lines[0].is_final);
  EXPECT_TRUE(scenario.lines[1].is_final);
  EXPECT_EQ(scenario.lines[1].number, 3U);
  EXPECT_THAT(mistake_in("finally\nfinally\n"), StartsWith("test.scn:2: "));
  EXPECT_THAT(mistake_in("finally disable 1.1\n"), HasSubstr("finally has no arguments"));
}

// ---- limits ------------------------------------------------------------------------------------

std::string repeated(const std::string& text, std::size_t count) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

TEST(ScenarioLimit, OfCommandsIsAtLeastOneThatIsNotFinal) {
  for (const std::string text : {"", "# a title\n\n", "let a = 1\n", "finally\n"}) {
    EXPECT_EQ(mistake_in(text), "test.scn: has no command: write at least one");
  }
  EXPECT_EQ(mistake_in("finally\nwait 1s\n"),
            "test.scn: has no command: write at least one above finally");
}

TEST(ScenarioLimit, OfALineIsTheLongestLineThatIsRead) {
  const std::string line = "wait 1s #";
  EXPECT_EQ(mistake_in("\n" + line + std::string(kLongestLine - line.size(), 'x') + "\n"), "none");
  EXPECT_THAT(mistake_in("\n" + line + std::string(kLongestLine - line.size() + 1, 'x') + "\n"),
              StartsWith("test.scn:2: the line has more than 32768 bytes"));
  EXPECT_THAT(mistake_in(std::string(std::size_t{1} << 26U, 'x')),
              StartsWith("test.scn:1: the line has more than 32768 bytes"));
}

TEST(ScenarioLimit, OfTheWordsOfALineHoldsForEachCommand) {
  EXPECT_EQ(mistake_in("enable" + repeated(" 1.1", kMostWords - 1) + "\n"), "none");
  EXPECT_THAT(mistake_in("wait 1s\nenable" + repeated(" 1.1", kMostWords) + "\n"),
              StartsWith("test.scn:2: the line has more than 4096 words"));
  EXPECT_THAT(mistake_in(repeated("refused 5 ", 10'000) + "\n"), HasSubstr("more than"));
}

TEST(ScenarioLimit, OfARefusalIsOneInALine) {
  EXPECT_THAT(mistake_in("wait 1s\nrefused 5 refused 6 list\n"),
              StartsWith("test.scn:2: 'refused' cannot be nested"));
  EXPECT_THAT(mistake_in(repeated("refused 5 ", 1'500) + "list\n"),
              StartsWith("test.scn:1: 'refused' cannot be nested"));
}

TEST(ScenarioLimit, OfALineHoldsWithTheValuesOfItsVariables) {
  std::string text = "let x0 = 1234567890\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = "${x" + std::to_string(i - 1) + "}";
    text += "let x" + std::to_string(i) + " = " + repeated(before, 10) + "\n";
  }
  EXPECT_THAT(mistake_in(text),
              StartsWith("test.scn:5: the line has more than 32768 bytes with the values of its"));
}

TEST(ScenarioLimit, OfAFileHoldsForItsBytesAndWithTheValuesOfItsVariables) {
  const std::string comment = "#" + std::string(1'022, 'x') + "\n";
  const std::string first = "wait 1s #" + std::string(1'014, 'x') + "\n";
  EXPECT_EQ(mistake_in(first + repeated(comment, 4'095)), "none");
  EXPECT_THAT(mistake_in(first + repeated(comment, 4'095) + "#\n"),
              StartsWith("test.scn:4097: the file has more than 4194304 bytes"));
  std::string text = "let x = " + std::string(20'000, '1') + "\n";
  for (int i = 0; i < 1'000; ++i) text += "let y" + std::to_string(i) + " = ${x}\n";
  EXPECT_THAT(mistake_in(text),
              HasSubstr("the file has more than 4194304 bytes with the values of its variables"));
}

TEST(Junit, CountsAndEscapes) {
  const std::vector<JunitCase> cases{
      {.name = "line 1: wait 1s", .duration = std::chrono::milliseconds(1500)},
      {.name = "line 2: a < b", .failure = "expected \"1\" & got\x01 2"},
      {.name = "line 3", .is_skipped = true},
      {.name = "start", .error = "no bench"}};
  const std::string xml = junit_xml({{"a.scn", cases}, {"b.scn", {{.name = "line 1"}}}});
  EXPECT_THAT(xml, HasSubstr("<testsuites tests=\"5\" failures=\"1\" skipped=\"1\" errors=\"1\""));
  EXPECT_THAT(xml, HasSubstr("<testsuite name=\"a.scn\" tests=\"4\" failures=\"1\" skipped=\"1\" "
                             "errors=\"1\" time=\"1.500000\""));
  EXPECT_THAT(xml, HasSubstr("<testsuite name=\"b.scn\" tests=\"1\" failures=\"0\""));
  EXPECT_THAT(xml, HasSubstr("name=\"line 2: a &lt; b\""));
  EXPECT_THAT(xml, HasSubstr("message=\"expected &quot;1&quot; &amp; got? 2\""));
  EXPECT_THAT(xml, HasSubstr("<skipped/>"));
  EXPECT_THAT(xml, HasSubstr("<error message=\"no bench\"/>"));
}

TEST(Junit, HasThePlaceTheKindAndTheTextOfAFailureAndWhatALinePrinted) {
  const std::vector<JunitCase> cases{{.name = "line 7: expect 1.1 mode 3",
                                      .failure = "mode: expected 3, actual 1",
                                      .line = 7,
                                      .type = "expectation",
                                      .text = "lift.scn:7: mode <> 3\n  next: look",
                                      .output = "1.1 mode = 1\n"},
                                     {.name = "start", .error = "no bench", .type = "failed"}};
  const std::string xml = junit_xml({{"lift.scn", cases}});
  EXPECT_THAT(xml, HasSubstr("<testcase classname=\"lift.scn\" name=\"line 7: expect 1.1 mode 3\" "
                             "time=\"0.000000\" file=\"lift.scn\" line=\"7\">"
                             "<failure message=\"mode: expected 3, actual 1\" "
                             "type=\"expectation\">lift.scn:7: mode &lt;&gt; 3\n  next: look"
                             "</failure><system-out>1.1 mode = 1\n</system-out></testcase>"));
  EXPECT_THAT(xml, HasSubstr("file=\"lift.scn\"><error message=\"no bench\" type=\"failed\"/>"));
}

Expectation expectation_of(const std::string& object, const std::string& value) {
  return parse_expectation(object, std::vector<std::string>{value});
}

// 0x1637: Operation enabled with bits 4, 9, 10 and 12; in 0x637, bit 12 is 0. 0x218: Fault, 0x237:
// enabled.
TEST(ExpectationOfAWord, NamesTheStateAndTheBitsThatDiffer) {
  const auto position = OperatingMode::profile_position;
  EXPECT_EQ(decoded_text(expectation_of("statusword", "0x637"), 0x1637, position),
            "Operation enabled, bit 12 set-point acknowledge is 1");
  Expectation masked = expectation_of("statusword", "0x400");
  masked.mask = 0x400;
  EXPECT_EQ(decoded_text(masked, 0x237, position), "Operation enabled, bit 10 target reached is 0");
  EXPECT_EQ(decoded_text(expectation_of("statusword", "0x2218"), 0x218, position),
            "Fault, bit 13 following error is 0");
  EXPECT_EQ(decoded_text(expectation_of("controlword", "0x0F"), 0x10F, position),
            "bit 8 halt is 1");
}

TEST(ExpectationOfAWord, HasTheStateAloneWhereNoBitIsExpected) {
  Expectation other = expectation_of("statusword", "0x637");
  other.comparison = Comparison::not_equal;
  EXPECT_EQ(decoded_text(other, 0x637, OperatingMode::profile_position), "Operation enabled");
  EXPECT_EQ(decoded_text(expectation_of("position", "5"), 4, OperatingMode::profile_position), "");
}

}  // namespace
}  // namespace vdrive::tool
