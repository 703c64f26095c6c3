// SPDX-License-Identifier: Apache-2.0
// `vdrive test` over both wires: all scenarios of the project, scenarios that fail, and one with
// every command that a scenario may contain give the same verdicts, cases and messages. The
// scenarios of the project also give the same events and the same journal, which contains every
// tick.
#include "base/exit_code.hpp"
#include "client/session_options.hpp"
#include "command_table.hpp"
#include "output/junit.hpp"
#include "scenarios/scenario_files.hpp"
#include "scenarios/scenario_run.hpp"
#include "support/effort.hpp"
#include "support/event_log.hpp"
#include "support/journal_comparison.hpp"
#include "support/process_tree.hpp"
#include "support/temporary_directory.hpp"
#include "terminal/terminal.hpp"
#include "tool/call.hpp"
#include "tool/process.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::SizeIs;

using Json = nlohmann::ordered_json;

/// The outcome of a call of `vdrive test`, without times, without the place of a search, and
/// without the order in which files that ran in parallel ended.
struct Verdicts {
  int code = 0;
  std::vector<std::string> lines;  ///< sorted
  std::string report;
};

std::string without_times(const std::string& text) {
  return std::regex_replace(text, std::regex(R"re( time="[0-9.]+")re"), "");
}

/// Removes where a search took place and which benches it saw.
std::string without_place(const std::string& text) {
  static const std::regex place(R"re( on (this bus|domain \d+)| \(seen: [^)]*\))re");
  return std::regex_replace(text, place, "");
}

std::vector<std::string> lines_without_times(const Finished& finished) {
  std::vector<std::string> lines;
  for (const std::string& line : finished.lines()) {
    Json json = Json::parse(line);
    json.erase("seconds");
    json.erase("owner");  // the random number of the session
    json.erase("owner_name");
    json.erase("host");  // a bench in the same process has none
    lines.push_back(json.dump());
  }
  return lines;
}

class BothWires : public testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& lines) {
    const std::string path = directory_.path() / name;
    std::ofstream(path) << lines;
    return path;
  }

  Verdicts test(std::vector<std::string> words, const std::string& wire) {
    const std::string report = directory_.path() / (wire + ".xml");
    words.insert(words.begin(), "test");
    words.insert(words.end(), {"--over", wire, "--json", "--junit", report});
    const Finished finished = Process(VDRIVE_TOOL, std::move(words)).wait();
    Verdicts verdicts{.code = finished.code, .lines = {}, .report = {}};
    for (const std::string& line : lines_without_times(finished)) {
      verdicts.lines.push_back(without_place(line));
    }
    std::ranges::sort(verdicts.lines);
    std::stringstream text;
    text << std::ifstream(report).rdbuf();
    verdicts.report = without_place(without_times(text.str()));
    return verdicts;
  }

  /// @return the verdicts, which are the same over both wires.
  Verdicts test_over_both(const std::vector<std::string>& words) {
    Verdicts local = test(words, "local");
    const Verdicts dds = test(words, "dds");
    EXPECT_EQ(local.code, dds.code);
    EXPECT_EQ(local.lines, dds.lines);
    EXPECT_EQ(local.report, dds.report);
    return local;
  }

  TemporaryDirectory directory_;
};

const std::filesystem::path kScenarios =
    std::filesystem::path(VDRIVE_SOURCE_DIR) / "clients" / "scenarios";

/// @return one scenario of each kind: the one that takes the least drive time.
std::vector<std::string> short_scenarios() {
  std::vector<std::string> files;
  for (const char* const name : {"blocked_axis", "fault_reset", "homing", "quick_stop", "refusals",
                                 "software_limits", "speed_limit"}) {
    files.push_back(kScenarios / (std::string(name) + ".scn"));
  }
  return files;
}

/// @return every scenario of the project with --full, which takes half a minute of processor time;
///         otherwise the short ones.
std::vector<std::string> scenarios_of_the_project() {
  if (!number_of<bool>({.usual = false, .full = true, .nightly = true})) return short_scenarios();
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(kScenarios)) {
    if (entry.path().extension() == ".scn") files.push_back(entry.path());
  }
  return files;
}

// The test below compares the verdicts of all, with their events and ticks; this one compares a
// report.
TEST_F(BothWires, GiveTheSameVerdictOfTheScenariosOfTheProject) {
  const std::vector<std::string> files = short_scenarios();
  ASSERT_FALSE(files.empty());
  const Verdicts verdicts = test_over_both(files);
  EXPECT_EQ(verdicts.code, 0);
  EXPECT_THAT(verdicts.lines, SizeIs(files.size() + 1)) << "one of each file, and the sum";
}

/// A session that runs a scenario, and the events that it receives.
class ScenarioSession {
 public:
  explicit ScenarioSession(const client::SessionOptions& options)
      : session_(options),
        numbers_({{session_.id(), "the session"}}),
        events_(session_, numbers_) {}

  /// @return exit code, lines of JSON and messages.
  Finished run(const std::string& file) {
    return captured([&] {
      const auto scenarios = tool::ScenarioFiles{.files = {file}}.load(tool::commands());
      tool::JunitReport no_report("");
      tool::Terminal terminal;
      const client::Outcome outcome =
          tool::run_scenarios(scenarios, {.is_json = true, .is_private = true, .timeout = {}},
                              no_report, session_, terminal);
      return static_cast<int>(tool::exit_code_of(outcome.kind()));
    });
  }

  /// Causes an event and waits for it; after that all earlier events are known.
  [[nodiscard]] bool await_events() {
    constexpr std::uint32_t kTaken = 1;
    const auto told = [this] {
      return events_.numbers_of(client::EventKind::snapshot, 0, kTaken, session_.id()).told;
    };
    const std::uint64_t before = told();
    session_.take_snapshot(kBench).outcome().or_throw();
    return holds_soon([&] {
      return told() > before;
    });
  }

  [[nodiscard]] const EventLog& events() const { return events_; }

 private:
  static constexpr std::uint32_t kBench = 1;

  client::Session session_;
  SessionNumbers numbers_;
  EventLog events_;
};

/// Runs the scenario in a bench of this process and over DDS.
void expect_same_run(ScenarioSession& local, ScenarioSession& over_dds, const std::string& file) {
  const Finished here = local.run(file);
  const Finished there = over_dds.run(file);
  EXPECT_EQ(here.code, 0) << here.errors;
  EXPECT_EQ(there.code, 0) << there.errors;
  EXPECT_EQ(lines_without_times(here), lines_without_times(there));
  EXPECT_EQ(here.errors, there.errors);
  EXPECT_TRUE(local.await_events());
  EXPECT_TRUE(over_dds.await_events());
  EXPECT_EQ(difference_of(local.events(), over_dds.events()), "");
  EXPECT_EQ(told_to_both(local.events(), over_dds.events()), local.events().count())
      << "a scenario causes fewer equal events than a bench lets pass at once";
}

TEST_F(BothWires, GiveTheSameEventsAndJournalOfTheScenariosOfTheProject) {
  std::uint64_t ticks = 0;
  for (const std::string& file : scenarios_of_the_project()) {
    SCOPED_TRACE(file);
    const TemporaryDirectory directory;
    const std::filesystem::path journal_over_dds = directory.path() / "journal.dds";
    const std::filesystem::path journal_here = directory.path() / "journal.local";
    {
      RunningService service("--clock lockstep --journal " + journal_over_dds.string());
      const bench::Bench bench({.journal = journal_here});
      {
        client::SessionOptions options;
        options.bus = bench.bus();
        ScenarioSession local(options);
        ScenarioSession over_dds(test::options());
        expect_same_run(local, over_dds, file);
      }
      EXPECT_EQ(service.stop().code, 0);
    }
    const JournalComparison journals = compare_journals(journal_here, journal_over_dds);
    EXPECT_EQ(journals.difference, "");
    ticks += journals.ticks;
  }
  EXPECT_GT(ticks, 1'000U) << "a scenario lets time pass";
}

TEST_F(BothWires, GiveTheSameMessagesOfScenariosThatFail) {
  const Verdicts verdicts = test_over_both(
      {file("expected.scn", "enable 1.1\nmove 1.1 500\nexpect 1.1 position < 100\nstep 1\n"),
       file("axis.scn", "enable 1.9\n"), file("name.scn", "enable nobody\n"),
       file("bench.scn", "step 1 --bench 7\n"), file("store.scn", "store 1.1\n"),
       file("refused.scn", "refused 0x06010002 write 1.1 0x6040 0\n"),
       file("late.scn", "wait 1.1 operation_enabled --timeout 5ms\n"),
       file("disabled.scn", "move 1.1 5\n"),
       file("restored.scn", "disturb 1.1 load_torque 100\nmove 1.1 5\nfinally\nstep 1\n"),
       file("fault.scn", "enable 1.1\ndisturb 1.1 over_current\nstep 5\nenable 1.1\n"),
       // Over DDS the search for a missing bench takes this long.
       "--timeout", "5"});
  EXPECT_THAT(verdicts.report, HasSubstr("failures=\"7\"")) << "those that are not below";
  EXPECT_THAT(verdicts.report, HasSubstr("errors=\"3\"")) << "axis, name and bench";
}

constexpr const char* kEveryCommand =
    "list\n"
    "status\n"
    "describe 1.2\n"
    "rate\n"
    "dictionary 0x6041\n"
    "snapshot take\n"
    "step 2\n"
    "enable 1.*\n"
    "watch 1.1 --count 1\n"
    "move 1.1 1000\n"
    "read 1.1 0x6041 position\n"
    "write 1.1 0x6081 5000\n"
    "expect 1.1 position 1000 --tolerance 1 --within 1s\n"
    "move 1.1 90000 --no-wait\n"
    "halt 1.1 --wait\n"
    "resume 1.1\n"
    "wait 20ms\n"
    "quick-stop 1.1\n"
    "enable 1.1\n"
    "velocity 1.1 500\n"
    "velocity 1.1 0\n"
    "jog 1.1 300 --for 20ms\n"
    "torque 1.1 0\n"
    "home 1.1 --method 35\n"
    "disturb 1.2 over_current\n"
    "wait 1.2 fault\n"
    "disturb 1.2 none\n"
    "reset 1.2\n"
    "disable 1.2\n"
    "stop\n"
    "power-cycle 1.1\n"
    "refused 0x08000020 store 1.1\n"
    "refused 0x08000020 restore 1.1\n"
    "snapshot restore 1\n"
    "snapshot list\n"
    "snapshot drop 1\n";

TEST_F(BothWires, GiveTheSameAnswersOfEveryCommandThatAScenarioMayHave) {
  const std::string scenario = file("every.scn", kEveryCommand);
  const auto run = [&](const std::string& wire) {
    return Process(VDRIVE_TOOL, {"run", "--private", "--over", wire, "--json", scenario}).wait();
  };
  const Finished local = run("local");
  const Finished dds = run("dds");
  EXPECT_EQ(local.code, 0) << local.errors;
  EXPECT_EQ(dds.code, 0) << dds.errors;
  EXPECT_EQ(local.errors, dds.errors);
  EXPECT_EQ(lines_without_times(local), lines_without_times(dds));
}

TEST(EveryCommand, IsThatOfTheTableOfTheTool) {
  std::set<std::string> used{"store", "restore"};  // follow `refused CODE`
  std::istringstream lines(kEveryCommand);
  for (std::string line; std::getline(lines, line);) used.insert(line.substr(0, line.find(' ')));
  for (const tool::CommandRow* const row : tool::commands()) {
    if (row->info.deepest != tool::Place::scenario) continue;
    EXPECT_THAT(used, Contains(std::string(row->info.name)));
  }
}

}  // namespace
}  // namespace vdrive::test
