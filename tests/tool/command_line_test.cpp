// SPDX-License-Identifier: Apache-2.0
// The commands of the command line and of scenarios.
#include "language/command_line.hpp"

#include "base/usage_error.hpp"
#include "command_table.hpp"
#include "commands/clock.hpp"
#include "commands/dictionary.hpp"
#include "commands/expect.hpp"
#include "commands/motion.hpp"
#include "commands/move.hpp"
#include "commands/objects.hpp"
#include "commands/power.hpp"
#include "commands/record.hpp"
#include "commands/run.hpp"
#include "commands/watch.hpp"
#include "csv_field.hpp"
#include "execution/axis_action.hpp"
#include "language/help.hpp"
#include "language/scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

namespace vdrive::tool {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;
using testing::ThrowsMessage;

std::vector<std::string> split(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

Invocation parse(const std::string& text) {
  return parse_command_line(commands(), split(text));
}

template <typename Word>
Word command(const std::string& text) {
  return std::any_cast<Word>(parse(text).command.value().arguments);
}

template <typename Word>
Word scenario_command(const std::string& text) {
  return std::any_cast<Word>(parse_scenario_command(commands(), split(text)).command.arguments);
}

std::string refusal_of(std::vector<std::string> words) {
  try {
    static_cast<void>(parse_command_line(commands(), std::move(words)));
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CommandLine, NamesTheFirstUnexpectedArgument) {
  EXPECT_EQ(refusal_of(split("move 1.1 5 --speed 3 --fast")),
            "'--speed' is not an option of 'vdrive move'");
  EXPECT_EQ(refusal_of(split("move 1.1 5 --velocty 3")),
            "'--velocty' is not an option of 'vdrive move' (did you mean '--velocity'?)");
  EXPECT_EQ(refusal_of(split("move 1.1 5 6 7")), "'6' is one argument too many for 'vdrive move'");
  EXPECT_EQ(refusal_of(split("write 1.1 0x6081 5 -5")),
            "'-5' is one argument too many for 'vdrive write'");
}

TEST(CommandLine, ExplainsTheOrderOfCommandAndOption) {
  EXPECT_EQ(refusal_of(split("--bench 7 step 1")),
            "'--bench' belongs after its command, such as 'vdrive step ... --bench'");
  EXPECT_EQ(refusal_of(split("--jsn list")), "'--jsn' is not an option (did you mean '--json'?)");
  EXPECT_EQ(refusal_of(split("--nothing=3 list")), "'--nothing' is not an option");
}

TEST(CommandLine, SuggestsAnObjectOfTheDictionary) {
  EXPECT_EQ(command<DictionaryCommand>("dictionary 0x607D").objects.size(), 1U);
  EXPECT_EQ(refusal_of(split("dictionary 0x9999")), "the dictionary has no object '0x9999'");
  EXPECT_EQ(refusal_of(split("dictionary profil_acc")),
            "the dictionary has no object 'profil_acc' (did you mean 'profile_acc'?)");
}

TEST(CommandLine, RefusesToShowAPartOfTheDictionaryOfANode) {
  EXPECT_EQ(command<DictionaryCommand>("dictionary --format eds").format, TableFormat::eds);
  EXPECT_EQ(command<DictionaryCommand>("dictionary --format node-json --json").format,
            TableFormat::node_json);
  EXPECT_EQ(refusal_of(split("dictionary statusword --format eds")),
            "'--format eds' has all objects of a node, so it takes no OBJECT; leave 'statusword' "
            "out");
  EXPECT_EQ(refusal_of(split("dictionary --format node-json --language zh")),
            "'--format node-json' is in English, so it takes no --language");
  EXPECT_EQ(refusal_of(split("dictionary --format eds --json")),
            "'--format eds' is not available as JSON: use 'vdrive dictionary --format node-json'");
}

TEST(CommandLine, TakesTheAxisOfANodeForADataSheetAlone) {
  const auto sheet = command<DictionaryCommand>("dictionary --format eds --node 12 --axis 2");
  EXPECT_EQ(sheet.node, 12U);
  EXPECT_EQ(sheet.axis_number, 2U);
  EXPECT_EQ(refusal_of(split("dictionary --node 3")),
            "--node applies to a data sheet only: add --format eds");
  EXPECT_EQ(refusal_of(split("dictionary --format eds --node 0")),
            "--node 0 means all nodes; a node-ID is 1 to 127");
  EXPECT_NE(refusal_of(split("dictionary --format eds --node 128")), "");
  EXPECT_EQ(refusal_of(split("dictionary --format eds --preset winder")),
            "--axis, --preset and --config say which axis a node is: add --node with its node-ID");
  EXPECT_EQ(refusal_of(split("dictionary --format eds --node 1 --preset winder --config a.yaml")),
            "--preset and --config cannot be used together");
}

TEST(CommandLine, ListsTheSubIndicesOfAnIndex) {
  EXPECT_EQ(refusal_of(split("dictionary 0x607D:7")),
            "the dictionary has no object '0x607D:7': 607Dh has sub-indices 1 and 2");
}

// CiA 402-2, 6060h: mode 5 is reserved.
TEST(CommandLine, ListsTheOperatingModesWhereOneIsTakenOrShown) {
  for (const char* const object : {"op_mode_cmd", "0x6061"}) {
    const std::vector<std::string> lines =
        dictionary_lines(command<DictionaryCommand>("dictionary " + std::string(object)));
    EXPECT_THAT(lines,
                AllOf(testing::Contains("  0   none"), testing::Contains("  2   velocity"),
                      testing::Contains("  7   interpolated position"),
                      testing::Contains("  9   cyclic synchronous velocity"),
                      testing::Contains("  10  cyclic synchronous torque"), testing::SizeIs(13)))
        << object << ": title and row, a title, and 0 to 4 and 6 to 10";
  }
}

// CiA 402-2, 6098h: 0 and the methods of the drive, some of which are tested here.
TEST(CommandLine, ListsTheHomingMethodsWhereOneIsTaken) {
  const std::vector<std::string> lines =
      dictionary_lines(command<DictionaryCommand>("dictionary homing_method"));
  const std::string help = parse("home --help").text;
  for (const char* const method : {"-4", "-1", "1", "14", "17", "30", "33", "34", "35", "37"}) {
    EXPECT_THAT(lines, testing::Contains(StartsWith("  " + std::string(method) + " "))) << method;
    EXPECT_THAT(help, HasSubstr(" " + std::string(method) + ": ")) << method;
  }
  EXPECT_THAT(lines, testing::Contains(StartsWith("  0 ")));
  EXPECT_THAT(dictionary_lines(command<DictionaryCommand>("dictionary profile_velocity")),
              testing::SizeIs(2))
      << "title and row";
}

TEST(CommandLine, SuggestsACommandAndADisturbance) {
  EXPECT_EQ(refusal_of(split("enabel 1.1")), "'enabel' is not a command (did you mean 'enable'?)");
  EXPECT_EQ(refusal_of(split("dance")),
            "'dance' is not a command; 'vdrive --help' lists all commands");
  EXPECT_THAT(refusal_of(split("disturb 1.1 overcurrent")),
              testing::EndsWith("or none (did you mean 'over_current'?)"));
  EXPECT_THAT(refusal_of(split("snapshot tak")), testing::EndsWith("(did you mean 'take'?)"));
  EXPECT_THAT(refusal_of(split("test a.scn --over lcal")),
              testing::EndsWith("'lcal' must be one of local, dds (did you mean 'local'?)"));
}

// CLI11 treats an empty value as a missing one.
TEST(CommandLine, RefusesAnEmptyValue) {
  EXPECT_EQ(refusal_of({"--security", "", "list"}), "--security: the value is empty");
  EXPECT_THAT(refusal_of({"--domain", "", "list"}), testing::StartsWith("--domain: "));
  EXPECT_EQ(refusal_of({"--timeout", "", "list"}), "--timeout: the value is empty");
  EXPECT_EQ(refusal_of({"move", "1.1", "100", "--velocity", ""}), "--velocity: the value is empty");
  setenv("VDRIVE_SECURITY", "", 1);  // NOLINT(*-mt-unsafe)
  EXPECT_EQ(refusal_of({"list"}),
            "VDRIVE_SECURITY in the environment is set, but empty: unset it or give a value");
  unsetenv("VDRIVE_SECURITY");  // NOLINT(*-mt-unsafe)
  EXPECT_EQ(refusal_of({"list"}), "accepted");
}

TEST(CommandLine, ShowsABadValueEscapedAndShortened) {
  const std::string bad = "a\n\x1B[31m" + std::string(100'000, 'b');
  const std::vector<std::vector<std::string>> lines{{bad},
                                                    {"move", "1.1", bad},
                                                    {"read", "1.1", bad},
                                                    {"move", "1.1", "1", "--velocity", bad},
                                                    {"disturb", "1.1", bad},
                                                    {"snapshot", bad},
                                                    {"record", bad},
                                                    {"--domain", bad, "list"},
                                                    {"--discovery-server", bad, "list"},
                                                    {"status", "1.1", "--" + bad}};
  for (const auto& line : lines) {
    const std::string refusal = refusal_of(line);
    EXPECT_THAT(refusal, HasSubstr(R"(\x1B[31mb)")) << line.front();
    EXPECT_LT(refusal.size(), 600U) << line.front();
    EXPECT_EQ(refusal.find_first_of("\n\x1B"), std::string::npos) << line.front();
  }
}

TEST(CommandLine, AcceptsGlobalOptionsBeforeAndAfterTheCommand) {
  for (const char* const text :
       {"--domain 7 --json --timeout 3 status 1.1", "status 1.1 --timeout 3 --json --domain 7",
        "--json status --domain=7 1.1 --timeout=3"}) {
    const Invocation invocation = parse(text);
    EXPECT_EQ(invocation.options.domain, 7U) << text;
    EXPECT_TRUE(invocation.options.json) << text;
    EXPECT_EQ(invocation.options.timeout, Duration(3s)) << text;
    EXPECT_THAT(invocation.command.value().axes, ElementsAre("1.1")) << text;
  }
}

TEST(CommandLine, AcceptsOneValueForEachNetworkOption) {
  const auto options = parse(
                           "--interface 10.0.0.3 --peer 10.0.0.1 --peer 10.0.0.2 "
                           "--discovery-server 10.0.0.9:11811 list --interface 10.1.0.3")
                           .options;
  EXPECT_EQ(options.interfaces, (std::vector<std::string>{"10.0.0.3", "10.1.0.3"}));
  EXPECT_EQ(options.peers, (std::vector<std::string>{"10.0.0.1", "10.0.0.2"}));
  EXPECT_EQ(options.discovery_servers, std::vector<std::string>{"10.0.0.9:11811"});
}

TEST(CommandLine, MoveAcceptsANegativePosition) {
  const auto move = command<MoveCommand>("move 1.1 -10000");
  EXPECT_EQ(move.position.value, -10000.0);
  EXPECT_FALSE(move.relative);
  EXPECT_FALSE(move.queue);
  EXPECT_EQ(move.until, client::Until::done);
  EXPECT_FALSE(move.velocity);
}

TEST(CommandLine, MoveAcceptsAllItsOptions) {
  const auto move = command<MoveCommand>(
      "move x 0xFFFFD8F0 --relative --velocity 1000 --acceleration 6000 --deceleration 7000 "
      "--queue --no-wait");
  EXPECT_EQ(move.axis, "x");
  EXPECT_EQ(move.position.value, -10000.0);
  EXPECT_TRUE(move.relative);
  EXPECT_TRUE(move.queue);
  EXPECT_EQ(move.velocity.value().value, 1000.0);
  EXPECT_EQ(move.acceleration.value().value, 6000.0);
  EXPECT_EQ(move.deceleration.value().value, 7000.0);
  EXPECT_EQ(move.until, client::Until::in_force);
}

TEST(CommandLine, WritesTheValueInTheTypeOfTheObject) {
  EXPECT_EQ(command<WriteCommand>("write 1.1 0x607A 0xFFFFD8F0").value, -10000);
  EXPECT_EQ(command<WriteCommand>("write 1.1 0x6081 0xFFFFD8F0").value, 4294957296);
  EXPECT_EQ(command<WriteCommand>("write 1.1 position_user_target_value -5").value, -5);
}

TEST(CommandLine, ReadsSeveralObjects) {
  const auto read = command<ReadCommand>("read 1.1 0x6041 0x607D:1 profile_acc");
  ASSERT_EQ(read.objects.size(), 3U);
  EXPECT_EQ(read.objects[1].address, (ObjectAddress{0x607D, 1}));
}

TEST(CommandLine, DisturbHasTheDefaultValueOne) {
  const auto blocked = command<DisturbCommand>("disturb 1.1 blocked_load --for 20ms");
  ASSERT_EQ(blocked.inputs.size(), 1U);
  EXPECT_EQ(blocked.inputs[0].object.address, (ObjectAddress{0x5E01, 0}));
  EXPECT_EQ(blocked.inputs[0].value, 1);
  EXPECT_EQ(blocked.duration, Duration(20ms));
  EXPECT_EQ(command<DisturbCommand>("disturb 1.1 load_torque -1500").inputs[0].value, -1500);
}

TEST(CommandLine, DisturbNoneClearsEveryInput) {
  const auto none = command<DisturbCommand>("disturb 1.1 none");
  EXPECT_EQ(none.inputs.size(), 13U);
  for (const Disturbance& input : none.inputs) EXPECT_EQ(input.value, 0);
}

TEST(CommandLine, AxisCommandsHaveTheirDefaultWait) {
  EXPECT_EQ(command<AxisActionCommand>("enable 1.1").until, client::Until::done);
  EXPECT_EQ(command<AxisActionCommand>("halt 1.1").until, client::Until::in_force);
  EXPECT_EQ(command<AxisActionCommand>("halt 1.1 --wait").until, client::Until::done);
  EXPECT_EQ(command<AxisActionCommand>("quick-stop 1.1").action->name, "quick-stop");
  EXPECT_EQ(command<AxisActionCommand>("quick-stop 1.1 --no-wait").until, client::Until::in_force);
  EXPECT_EQ(command<AxisActionCommand>("power-cycle 1.1").action->name, "power-cycle");
  EXPECT_EQ(command<AxisActionCommand>("store 1.1").action->name, "store");
  EXPECT_EQ(command<AxisActionCommand>("restore 1.1").action->name, "restore");
}

TEST(CommandLine, StopAcceptsABenchOrUsesTheOnlyOne) {
  EXPECT_EQ(command<StopCommand>("stop").bench, std::nullopt);
  EXPECT_EQ(command<StopCommand>("stop 3").bench, 3U);
  EXPECT_EQ(command<StopCommand>("stop").until, client::Until::done);
  EXPECT_EQ(command<StopCommand>("stop 3 --no-wait").until, client::Until::in_force);
}

TEST(CommandLine, AxisCommandsTakeOverWithTheirOption) {
  for (const std::string word : {"enable", "disable", "halt", "resume", "quick-stop", "reset",
                                 "power-cycle", "store", "restore"}) {
    EXPECT_FALSE(command<AxisActionCommand>(word + " 1.1").take_over) << word;
    EXPECT_TRUE(command<AxisActionCommand>(word + " 1.1 --take-over").take_over) << word;
  }
  EXPECT_TRUE(command<MoveCommand>("move 1.1 5 --take-over").take_over);
  EXPECT_TRUE(command<WriteCommand>("write 1.1 0x6040 6 --take-over").take_over);
}

TEST(CommandLine, MoveStopsOnAnInterruptWithItsOption) {
  EXPECT_FALSE(command<MoveCommand>("move 1.1 5").stop_on_interrupt);
  EXPECT_TRUE(command<MoveCommand>("move 1.1 5 --stop-on-interrupt").stop_on_interrupt);
}

TEST(CommandLine, OtherCommandsAreParsed) {
  EXPECT_THAT(command<WatchCommand>("watch 1.1 y --count 5").axes, ElementsAre("1.1", "y"));
  EXPECT_EQ(command<WatchCommand>("watch 1.1 --count 5").count, 5U);
  EXPECT_EQ(command<StepCommand>("step 100 --bench 3").bench, 3U);
  EXPECT_EQ(command<StepCommand>("step 100").ticks, 100U);
  EXPECT_EQ(command<SnapshotCommand>("snapshot take").action, SnapshotCommand::Action::take);
  EXPECT_EQ(command<SnapshotCommand>("snapshot restore 7").snapshot, 7U);
  EXPECT_EQ(command<SnapshotCommand>("snapshot drop 7 --bench 2").bench, 2U);
  EXPECT_EQ(command<SnapshotCommand>("snapshot list").action, SnapshotCommand::Action::list);
  EXPECT_EQ(command<RateCommand>("rate 0").rate, 0.0);
  EXPECT_EQ(command<RateCommand>("rate").rate, std::nullopt);
  EXPECT_FALSE(command<RateCommand>("rate 0.5").bench);
  EXPECT_EQ(command<RateCommand>("rate 3 0.5").bench, 3U);
  EXPECT_EQ(command<RateCommand>("rate 3 0.5").rate, 0.5);
  EXPECT_EQ(command<RunCommand>("run - --junit out.xml").scenarios.junit, "out.xml");
  EXPECT_THAT(command<RunCommand>("run - b.scn").scenarios.files,
              testing::ElementsAre("-", "b.scn"));
  EXPECT_EQ(command<DictionaryCommand>("dictionary --format csv --language zh").language,
            Language::zh);
}

TEST(CommandLine, TheExtensionOfARecordingGivesItsFormat) {
  EXPECT_EQ(command<RecordCommand>("record a.csv").choice.format, recording::Format::csv);
  EXPECT_EQ(command<RecordCommand>("record a.jsonl").choice.format, recording::Format::json_lines);
  EXPECT_EQ(command<RecordCommand>("record a.mcap").choice.format, recording::Format::mcap);
  EXPECT_EQ(command<RecordCommand>("record -").choice.format, recording::Format::csv);
  EXPECT_EQ(command<RecordCommand>("--json record -").choice.format, recording::Format::json_lines);
  const auto record = command<RecordCommand>("record a.csv 1.1 y --for 20ms --count 7");
  EXPECT_THAT(record.axes, ElementsAre("1.1", "y"));
  EXPECT_EQ(record.choice.duration, Duration(20'000'000));
  EXPECT_EQ(record.choice.count, 7U);
  EXPECT_THROW(parse("record a.txt"), UsageError);
}

TEST(CommandLine, ConvertAcceptsTwoFilesOfDifferentFormatsAndThePeriodOfAText) {
  EXPECT_NO_THROW(parse("convert a.csv b.mcap --period 500us"));
  EXPECT_NO_THROW(parse("convert a.mcap b.jsonl"));
  for (const char* const words :
       {"convert a.csv", "convert a.csv b.txt", "convert a.csv b.csv", "convert a.json b.jsonl",
        "convert a.mcap b.csv --period 1ms", "convert a.csv b.mcap --period 0ms"}) {
    EXPECT_THROW(parse(words), UsageError) << words;
  }
}

TEST(Recording, QuotesACsvFieldWhereNeeded) {
  EXPECT_EQ(recording::csv_field("lift"), "lift");
  EXPECT_EQ(recording::csv_field("lift, left"), "\"lift, left\"");
  EXPECT_EQ(recording::csv_field("the \"lift\""), "\"the \"\"lift\"\"\"");
}

// Covers new rows that have no other test yet.
TEST(CommandTable, EachExampleIsReadAsItsCommand) {
  ASSERT_GT(commands().size(), 30U);
  for (const CommandRow* const row : commands()) {
    std::istringstream lines{std::string(row->info.example)};
    for (std::string line; std::getline(lines, line);) {
      std::vector<std::string> words = split_words(line.substr(0, line.find(" > ")));
      if (words.front() == "vdrive") words.erase(words.begin());
      const std::optional<Command> command = parse_command_line(commands(), words).command;
      ASSERT_TRUE(command) << line;
      EXPECT_EQ(command->row, row) << line;
    }
  }
}

// A group in two places would show its title only above the first.
TEST(CommandTable, HasTheCommandsOfAGroupSideBySide) {
  std::vector<CommandGroup> groups;
  for (const CommandRow* const row : commands()) {
    if (groups.empty() || groups.back() != row->info.group) groups.push_back(row->info.group);
  }
  std::vector<CommandGroup> sorted = groups;
  std::ranges::sort(sorted);
  EXPECT_EQ(std::ranges::adjacent_find(sorted), sorted.end());
  const std::string help = parse("--help").text;
  std::size_t place = 0;
  for (const CommandGroup group : groups) {
    place = help.find("\n" + std::string(title_of(group)) + ":\n", place);
    ASSERT_NE(place, std::string::npos) << title_of(group);
  }
}

TEST(CommandLine, HelpHasExamples) {
  EXPECT_THAT(parse("--help").text, HasSubstr("vdrive move 1.1 10000"));
  EXPECT_THAT(parse("--help").text, HasSubstr("Exit codes"));
  EXPECT_THAT(parse("move --help").text, HasSubstr("--acceleration"));
  EXPECT_THAT(parse("run --help").text, HasSubstr("--throughout"));
}

TEST(CommandLine, AcceptsSeveralAxesAndAll) {
  EXPECT_THAT(command<AxisActionCommand>("enable 7.1 7.2").axes, ElementsAre("7.1", "7.2"));
  EXPECT_THAT(command<AxisActionCommand>("quick-stop 7.*").axes, ElementsAre("7.*"));
  EXPECT_THAT(command<AxisActionCommand>("reset --all").axes, ElementsAre("*"));
  EXPECT_THAT(parse("status").command.value().axes, testing::IsEmpty());
}

TEST(CommandLine, ReadsHomeVelocityTorqueAndJog) {
  const auto home = command<HomeCommand>(
      "home x --method 37 --offset -90deg --speed 1000 --creep 9deg/s --acceleration 5 --no-wait");
  EXPECT_EQ(home.method, 37);
  EXPECT_EQ(home.offset.value().value, -90.0);
  EXPECT_EQ(home.search_speed.value().value, 1'000.0);
  EXPECT_EQ(home.creep_speed.value().unit, "deg");
  EXPECT_EQ(home.acceleration.value().value, 5.0);
  EXPECT_EQ(home.until, client::Until::in_force);
  const auto velocity = command<VelocityCommand>("velocity x -180deg/s --deceleration 7");
  EXPECT_EQ(velocity.run_at.velocity.value, -180.0);
  EXPECT_FALSE(velocity.run_at.acceleration);
  EXPECT_EQ(velocity.run_at.deceleration.value().value, 7.0);
  EXPECT_EQ(velocity.until, client::Until::done);
  EXPECT_EQ(command<TorqueCommand>("torque x -12.5%").torque, -125);
  EXPECT_EQ(command<TorqueCommand>("torque x 30 --slope 500").slope, 500U);
  EXPECT_EQ(command<JogCommand>("jog x 90deg/s").duration, std::nullopt);
  EXPECT_EQ(command<JogCommand>("jog x 90deg/s --for 2s").duration, Duration(2s));
  EXPECT_THROW(static_cast<void>(parse_scenario_command(commands(), split("jog x 90deg/s"))),
               UsageError)
      << "a scenario has no Enter key";
}

/// @return the reason for refusing the private benches of this command line; empty if they are
///         valid.
std::string refusal_of_benches(const std::string& text) {
  const Invocation invocation = parse(text);
  try {
    std::any_cast<RunCommand>(invocation.command.value().arguments)
        .benches.check(invocation.options);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(PrivateBenchesOfRun, RefuseWhatBelongsToABenchOverDdsAndSayHowToGetIt) {
  EXPECT_EQ(refusal_of_benches("run --private a.scn"), "");
  EXPECT_THAT(refusal_of_benches("run --private a.scn --service /bin/true"),
              AllOf(HasSubstr("--service"), HasSubstr("add --over dds")));
  EXPECT_THAT(refusal_of_benches("--security keys run --private a.scn"),
              AllOf(HasSubstr("--security"), HasSubstr("add --over dds")));
  EXPECT_EQ(refusal_of_benches("--security keys run --private a.scn --over dds --service "
                               "/bin/true"),
            "");
}

TEST(PrivateBenchesOfRun, AreOnNoNetworkThatIsGiven) {
  for (const char* const option : {"--domain 5", "--interface 127.0.0.1", "--peer 127.0.0.1",
                                   "--discovery-server 127.0.0.1:11811"}) {
    const std::string name = std::string(option).substr(0, std::string(option).find(' '));
    for (const char* const wire : {"local", "dds"}) {
      EXPECT_THAT(refusal_of_benches("run --private a.scn --over " + std::string(wire) + " " +
                                     std::string(option)),
                  AllOf(StartsWith(name), HasSubstr("a running bench")));
    }
  }
}

TEST(PrivateBenchesOfRun, IgnoreTheNetworkOfTheEnvironment) {
  setenv("VDRIVE_SECURITY", "/keys", 1);  // NOLINT(concurrency-mt-unsafe): one thread
  const std::string refusal = refusal_of_benches("run --private a.scn");
  unsetenv("VDRIVE_SECURITY");  // NOLINT(concurrency-mt-unsafe): one thread
  EXPECT_EQ(refusal, "");
}

struct BadRow {
  const char* name;
  const char* text;
  const char* message;
};

class BadCommandLine : public testing::TestWithParam<BadRow> {};

TEST_P(BadCommandLine, IsAUsageErrorWithItsReason) {
  EXPECT_THAT(
      [] {
        (void)parse(GetParam().text);
      },
      ThrowsMessage<UsageError>(HasSubstr(GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(
    Lines, BadCommandLine,
    testing::Values(
        BadRow{"nothing", "", "--help"}, BadRow{"an_unknown_word", "dance 1.1", "dance"},
        BadRow{"no_axis", "enable", "AXIS is required, or --all"},
        BadRow{"all_and_an_axis", "enable 1.1 --all", "--all cannot be combined with AXIS"},
        BadRow{"a_speed_without_a_second", "velocity 1.1 180deg", "180deg/s"},
        BadRow{"a_torque_in_words", "torque 1.1 much", "much"},
        BadRow{"a_torque_too_wide", "torque 1.1 4000%", "-32768 to 32767"},
        BadRow{"a_method_too_wide", "home 1.1 --method 300", "-128 to 127"},
        BadRow{"a_snapshot_without_a_number", "snapshot restore", "the number"},
        BadRow{"a_list_of_snapshots_with_a_number", "snapshot list 1", "no number"},
        BadRow{"a_number_for_a_new_snapshot", "snapshot take 1", "no number"},
        BadRow{"an_unknown_action", "snapshot shoot", "take, list, restore or drop"},
        BadRow{"no_position", "move 1.1", "POSITION"},
        BadRow{"one_word_too_many", "write 1.1 0x6081 5 1.2", "1.2"},
        BadRow{"an_unknown_option", "enable 1.1 --fast", "--fast"},
        BadRow{"a_domain_too_high", "--domain 233 list",
               "--domain: '233' must be a whole number from 0 to 232"},
        BadRow{"a_domain_in_words", "--domain ten list", "'ten' must be a whole number from 0 to"},
        BadRow{"a_position_too_wide", "move 1.1 3000000000", "3000000000"},
        BadRow{"a_negative_velocity", "move 1.1 5 --velocity -3", "-3"},
        BadRow{"a_value_too_wide", "write 1.1 0x6060 300", "-128 to 127"},
        BadRow{"an_unknown_kind", "disturb 1.1 earthquake", "blocked_load"},
        BadRow{"an_unknown_format", "dictionary --format yaml", "yaml"},
        BadRow{"negative_steps", "step -1", "-1"}, BadRow{"rate_in_words", "rate fast", "fast"},
        BadRow{"rate_of_too_much", "rate 1 2 3", "at most a bench"},
        BadRow{"no_timeout", "list --timeout soon", "soon"},
        BadRow{"no_interface", "--interface 10.0.0 list", "--interface"},
        BadRow{"no_peer", "--peer 10.0.0.256 list", "--peer"},
        BadRow{"no_port", "--discovery-server 10.0.0.9 list", "HOST:PORT"},
        BadRow{"port_0", "--discovery-server 10.0.0.9:0 list", "HOST:PORT"},
        BadRow{"a_word_of_scenarios", "refused 5 list", "refused"},
        BadRow{"an_unknown_wire", "test a.scn --over air", "'air' must be one of local, dds"},
        BadRow{"a_wire_of_no_private_bench", "run a.scn --over local", "--private"},
        BadRow{"a_configuration_of_no_private_bench", "run a.scn --config a.yaml", "--private"},
        BadRow{"a_service_of_no_private_bench", "run a.scn --service vdrived", "--private"}),
    [](const auto& row) {
      return row.param.name;
    });

TEST(ScenarioCommand, ExpectAcceptsMaskToleranceAndTimes) {
  const auto masked =
      scenario_command<ExpectCommand>("expect 1.1 0x6041 0x400 --mask 0x400 --within 20ms");
  EXPECT_EQ(masked.expectation.mask, 0x400U);
  EXPECT_EQ(masked.expectation.within, Duration(20ms));
  const auto near =
      scenario_command<ExpectCommand>("expect 1.1 0x6064 -5 --tolerance 2 --throughout 1s");
  EXPECT_EQ(near.expectation.value, -5);
  EXPECT_EQ(near.expectation.tolerance, 2U);
  EXPECT_EQ(near.expectation.throughout, Duration(1s));
}

TEST(ScenarioCommand, WaitAndRefusedAreParsed) {
  EXPECT_EQ(scenario_command<WaitCommand>("wait 1.5s").duration, Duration(1500ms));
  const Command refused =
      parse_scenario_command(commands(), split("refused 0x06010002 write 1.1 0x6041 -0")).command;
  EXPECT_EQ(refused.refusal, 0x06010002U);
  EXPECT_EQ(refused.row->info.name, "write");
  EXPECT_THAT(refused.axes, ElementsAre("1.1"));
}

TEST(ScenarioCommand, HasOneGrammarForEveryDurationAndNumber) {
  for (const char* const text : {"5", "5s", "5 s", "5e3ms", "5000ms"}) {
    const std::string option = std::string("--for=") + text;
    const Command disturbed =
        parse_scenario_command(commands(), {"disturb", "1.1", "load_torque", "1e3", option})
            .command;
    const auto& given = std::any_cast<const DisturbCommand&>(disturbed.arguments);
    EXPECT_EQ(given.duration, Duration(5s)) << text;
    EXPECT_EQ(given.inputs.front().value, 1'000) << text;
    EXPECT_EQ(parse_scenario_command(commands(), {"wait", text}).command.row->info.name, "wait");
    EXPECT_EQ(parse_scenario_command(commands(), {"enable", "1.1", "--timeout", text}).timeout,
              Duration(5s))
        << text;
  }
  EXPECT_EQ(scenario_command<StepCommand>("step 1e3").ticks, 1'000U);
}

TEST(CommandLine, ReadsADomainByTheGrammarOfAllNumbers) {
  EXPECT_EQ(parse("--domain 0x10 list").options.domain, 16U);
  EXPECT_EQ(parse("--domain 010 list").options.domain, 10U);
}

TEST(ScenarioCommand, AcceptsATimeoutForTheLine) {
  EXPECT_EQ(parse_scenario_command(commands(), split("move 1.1 5 --timeout 9")).timeout,
            Duration(9s));
}

class BadScenarioCommand : public testing::TestWithParam<BadRow> {};

TEST_P(BadScenarioCommand, IsAUsageErrorWithItsReason) {
  EXPECT_THAT(
      [] {
        (void)parse_scenario_command(commands(), split(GetParam().text));
      },
      ThrowsMessage<UsageError>(HasSubstr(GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(
    Lines, BadScenarioCommand,
    testing::Values(
        BadRow{"mask_and_tolerance", "expect 1.1 0x6041 0 --mask 1 --tolerance 1", "--mask"},
        BadRow{"within_and_throughout", "expect 1.1 0x6041 0 --within 1s --throughout 1s",
               "--within"},
        BadRow{"a_run_in_a_run", "run other.scn", "run"}, BadRow{"help", "--help", "help"},
        BadRow{"help_of_a_word", "move --help", "help"},
        BadRow{"a_domain", "--domain 3 status 1.1", "--domain"},
        BadRow{"an_endless_watch", "watch 1.1", "--count"},
        BadRow{"a_wait_for_an_axis_without_a_condition", "wait 1.1",
               "'1.1' is an axis: write what to wait for, such as 'wait 1.1 "
               "target_reached', or the unit of a time, such as 'wait 1.1s'"},
        BadRow{"a_word_of_conditions", "wait 1.1 enabled",
               "'enabled' is not a condition (did you mean 'operation_enabled' or "
               "'voltage_enabled'?)"},
        BadRow{"a_mistyped_condition", "wait 1.1 target_reachd",
               "(did you mean 'target_reached'?)"},
        BadRow{"no_condition", "wait 1.1 nothing",
               "'nothing' is not a condition; 'vdrive wait --help' lists all conditions"},
        BadRow{"a_fraction_of_an_object", "write 1.1 0x6073 12.5", "'12.5' is a fraction"},
        BadRow{"a_fraction_of_a_speed", "write 1.1 0x6081 12.5", "'12.5' is a fraction"},
        BadRow{"an_index_in_decimal", "read 1.1 6041", "did you mean 0x6041 or 6041h"},
        BadRow{"a_refusal_of_nothing", "refused 0x06010002", "command"},
        BadRow{"a_refusal_without_code", "refused write 1.1 0x6041 0", "'write'"}),
    [](const auto& row) {
      return row.param.name;
    });

TEST(Expectation, ComparesExactlyUnderAMaskOrWithATolerance) {
  Expectation expect;
  expect.value = 0x1237;
  EXPECT_TRUE(expect.accepts(0x1237));
  EXPECT_FALSE(expect.accepts(0x1637));
  expect.mask = 0x1000;
  EXPECT_TRUE(expect.accepts(0x1637));
  EXPECT_FALSE(expect.accepts(0x637));
  expect.mask.reset();
  expect.value = -5;
  expect.tolerance = 2;
  EXPECT_TRUE(expect.accepts(-7));
  EXPECT_TRUE(expect.accepts(-3));
  EXPECT_FALSE(expect.accepts(-8));
}

TEST(Expectation, AcceptsTolerancesAtTheEndsOfTheType) {
  Expectation expect;
  expect.value = std::numeric_limits<std::int32_t>::min();
  expect.tolerance = 10;
  EXPECT_FALSE(expect.accepts(std::numeric_limits<std::int32_t>::max()));
}

}  // namespace
}  // namespace vdrive::tool
