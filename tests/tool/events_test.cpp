// SPDX-License-Identifier: Apache-2.0
// `vdrive events`: the history of a bench.
#include "support/bench_on_wire.hpp"
#include "tool/call.hpp"
#include "tool/json_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

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

// 2310h: continuous over current.
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

// A bench keeps 1,024 events of a kind. Each epoch is a change of control of its own: 1,100 of them
// would leave no place for the fault before them.
TEST_F(Events, KeepAFaultThroughAFloodOfOthers) {
  client::Session session(options_on_wire());
  const auto axis = session.axis("1.2");
  ASSERT_TRUE(axis) << axis.outcome().message();
  for (int time = 0; time < 1'100; ++time) {
    ASSERT_TRUE(session.acquire(std::array{axis->id()}));
    ASSERT_TRUE(session.release());
  }
  const Finished finished = call("events");
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output, HasSubstr("  1.1  fault 0x2310\n"));
  const Finished described = call("describe 1.1");
  EXPECT_THAT(described.output, ContainsRegex("last fault  0x2310 .* in tick [0-9]+"));
}

TEST_F(Events, OfAMissingBenchOrAxisAreNotFound) {
  EXPECT_EQ(call("events 7 --timeout 0.2").code, 3);
  EXPECT_EQ(call("events 1.7").code, 3);
}

}  // namespace
}  // namespace vdrive::test
