// SPDX-License-Identifier: Apache-2.0
// `vdrive events`: the event history of a bench.
#include "command_table.hpp"
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"
#include "tool/json_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class Events : public testing::Test {
 protected:
  Events() { EXPECT_EQ(call("run -", "enable 1.1\ndisturb 1.1 over_current\nwait 5ms\n").code, 0); }

  BenchOnWire bench_{"--clock lockstep"};
};

// 2310h: continuous over-current.
TEST_F(Events, AreShownFromTheHistoryOfTheBench) {
  const Finished finished = call("events");
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output, AllOf(HasSubstr("  1.1  Operation enabled\n"),
                                     HasSubstr("  1.1  fault 0x"), HasSubstr("controlled by")));
  EXPECT_THAT(finished.output,
              ContainsRegex("controlled by .+ \\(process [0-9]+ on .+\\), session 0x[0-9a-f]{16}"))
      << "the program of the session that the bench names by its number";
  EXPECT_THAT(call("events 1.2").output, Not(HasSubstr("1.1")));
  EXPECT_THAT(call("events x").output, HasSubstr("fault"));
  EXPECT_THAT(call("events 1").output, HasSubstr("fault"));
}

TEST_F(Events, AreJsonAsDocumented) {
  const Finished finished = call("events x --json");
  ASSERT_EQ(finished.code, 0) << finished.errors;
  ASSERT_THAT(finished.lines(), Not(IsEmpty()));
  const Json event = Json::parse(finished.lines().front());
  std::vector<std::string> keys;
  for (const auto& [key, value] : event.items()) keys.push_back(key);
  EXPECT_THAT(keys, ElementsAre("bench", "axis", "tick", "kind", "code", "error_register",
                                "session", "session_name", "suppressed", "text"));
  EXPECT_EQ(event["axis"], "1.1");
}

TEST_F(Events, HaveTheNameOfTheirSessionInJson) {
  int named = 0;
  for (const std::string& line : call("events --json").lines()) {
    const Json event = Json::parse(line);
    const Json& name = event["session_name"];
    EXPECT_EQ(name.is_null(), event["session"].is_null()) << line;
    if (!name.is_object()) continue;
    ++named;
    EXPECT_NE(name["program"].get<std::string>(), "") << line;
    EXPECT_GT(name["process"].get<int>(), 0) << line;
    EXPECT_NE(name["host"].get<std::string>(), "") << line;
  }
  EXPECT_GT(named, 0);
}

TEST_F(Events, OfAMissingBenchOrAxisAreNotFound) {
  EXPECT_EQ(call("events 7 --timeout 0.2").code, 3);
  EXPECT_EQ(call("events 1.7").code, 3);
}

/// Runs commands as intended, one after the other, on a bench without a fault.
class HealthyBench : public testing::Test {
 protected:
  /// Calls the commands and checks that the bench has refused nothing.
  /// @return the number of events that it keeps.
  std::size_t call_all(const std::vector<std::string>& lines) {
    for (const std::string& line : lines) {
      const Finished finished = call(with_directory(line), kInput);
      EXPECT_EQ(finished.code, 0) << line << ": " << finished.errors;
      called_.insert(line.substr(0, line.find(' ')));
    }
    const std::vector<std::string> events = call("events --json").lines();
    for (const std::string& shown : events) {
      const Json event = Json::parse(shown);
      EXPECT_NE(event["kind"], "refused") << shown;
      EXPECT_NE(event["kind"], "set_point_ignored") << shown;
    }
    return events.size();
  }

  [[nodiscard]] const std::set<std::string>& called() const { return called_; }

  [[nodiscard]] std::string with_directory(std::string text) const {
    for (auto place = text.find("DIR"); place != std::string::npos; place = text.find("DIR")) {
      text.replace(place, 3, directory_.path());
    }
    return text;
  }

 private:
  static constexpr const char* kInput = "status 1.1\n";  // for a shell and a scenario

  TemporaryDirectory directory_;
  std::set<std::string> called_;
};

TEST_F(HealthyBench, RefusesNothingOfAnyCommandOfTheTool) {
  {
    const BenchOnWire bench(with_directory("--clock realtime --state DIR"));
    const std::vector<std::string> commands{"list",
                                            "status",
                                            "describe 1.1",
                                            "watch --count 1",
                                            "events",
                                            "enable 1.1",
                                            "home 1.1",
                                            "move 1.1 100",
                                            "move 1.1 50 --relative",
                                            "velocity 1.1 500",
                                            "halt 1.1",
                                            "resume 1.1",
                                            "stop 1",
                                            "enable 1.1",
                                            "torque 1.1 0%",
                                            "quick-stop 1.1",
                                            "enable 1.1",
                                            "jog 1.1 500 --for 50ms",
                                            "read 1.1 0x6041",
                                            "write 1.1 0x6081 1000",
                                            "dictionary 0x607D",
                                            "disturb 1.1 load_torque 5 --for 20ms",
                                            "expect 1.1 mode 3",
                                            "wait 20ms",
                                            "disable 1.1",
                                            "disturb 1.1 over_current",
                                            "disturb 1.1 none",
                                            "faults",
                                            "faults show 1 --to DIR/fault.mcap",
                                            "reset 1.1",
                                            "store 1.1",
                                            "restore 1.1",
                                            "power-cycle 1.1",
                                            "record DIR/run.mcap 1.1 --for 20ms",
                                            "convert DIR/run.mcap DIR/run.csv",
                                            "plot 1.1 --for 20ms -o DIR/now.svg",
                                            "plot DIR/run.csv --axis 1.1 -o DIR/run.svg",
                                            "run -",
                                            "shell",
                                            "completion bash",
                                            "rate 0",
                                            "snapshot take",
                                            "snapshot list",
                                            "snapshot restore 1",
                                            "snapshot drop 1",
                                            "rate 1"};
    EXPECT_GT(call_all(commands), 0U);
  }
  const BenchOnWire bench("--clock lockstep");
  (void)call_all({"step 10", "step 10 --steppers 1"});
  for (const tool::CommandRow* const row : tool::commands()) {
    const std::string name(row->info.name);
    // test, bench and demo start their own benches; doctor reads the network
    // (tool_processes_test); judge reads a log (tool_judge_test).
    const bool is_elsewhere =
        name == "test" || name == "bench" || name == "demo" || name == "doctor" || name == "judge";
    EXPECT_NE(called().contains(name), is_elsewhere) << name << " is not called";
  }
}

}  // namespace
}  // namespace vdrive::test
