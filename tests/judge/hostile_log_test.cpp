// SPDX-License-Identifier: Apache-2.0
// Logs with times, parameters and data sheets that nobody would write on purpose.
#include "judge/axis_track.hpp"
#include "judge/judged_drive.hpp"
#include "judge/judged_log.hpp"
#include "judge/logged_node.hpp"
#include "log/bus_log.hpp"
#include "node/data_sheet_reader.hpp"
#include "node/electronic_data_sheet.hpp"
#include "vdrive/cia402/controlword.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <sstream>
#include <string>
#include <utility>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

/// @return `log` with its times shifted by `shift`.
std::string later(const std::string& log, std::chrono::milliseconds shift) {
  constexpr std::size_t kMilliseconds = 15;  // "(0000000001.002" of "(0000000001.002300)"
  std::string text;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    const long time = 1'000 * std::stol(line.substr(1, 10)) + std::stol(line.substr(12, 3)) +
                      static_cast<long>(shift.count());
    char number[32];
    std::snprintf(number, sizeof(number), "(%010ld.%03ld", time / 1'000, time % 1'000);
    text += number + line.substr(kMilliseconds) + "\n";
  }
  return text;
}

std::string session(bool moves) {
  LoggedNode node;
  node.enable(kProfilePosition);
  if (moves) node.move(10'000);
  if (moves) node.move(-4'000);
  node.disable();
  return node.log();
}

TEST(ALogWhoseClockGoesBackOnce, IsJudgedByTheTimesAfterwards) {
  const LogVerdict result = judged(later(session(false), 5'000s) + session(true));
  EXPECT_THAT(broken_rules(result.verdict), IsEmpty());
  EXPECT_EQ(result.lines.backwards, 1U);
  EXPECT_GT(result.verdict.last - result.verdict.first, 200ms);
}

/// Two edges of bit 4 without reading bit 12 between them. Before the second edge, the clock goes
/// back by `step`.
LogVerdict mistake_over_a_step_back(std::chrono::milliseconds step) {
  LoggedNode node;
  node.enable(kProfilePosition);
  node.pdo(3, {{kEnabled, 2}, {1'000, 4}});
  node.step(2);
  node.word(kSetPoint);
  node.step(5);
  const std::size_t before = node.log().size();
  node.word(kEnabled);
  node.word(kSetPoint);
  node.step(5);
  return judged(later(node.log().substr(0, before), step) + node.log().substr(before));
}

TEST(ALogWhoseClockGoesBackOnce, KeepsWhatItKnewWhereTheStepIsShort) {
  const LogVerdict result = mistake_over_a_step_back(500ms);
  EXPECT_THAT(broken_rules(result.verdict), ElementsAre("handshake-1"));
  EXPECT_EQ(result.lines.backwards, 1U);
}

TEST(ALogWhoseClockGoesBackOnce, KnowsNothingAfterALongStep) {
  const LogVerdict result = mistake_over_a_step_back(1'500ms);
  EXPECT_THAT(broken_rules(result.verdict), IsEmpty());
  EXPECT_EQ(result.lines.backwards, 1U);
}

TEST(ALogWhoseClockJumps, NeverLeavesTheRangeOfTimes) {
  std::string log;
  for (int i = 0; i < 10; ++i) {
    log += "(3999999999.0) can0 185#3702\n(0.0) can0 205#0F00\n";
    log += " (2089-12-31 23:59:59.9) can0  205   [2]  0F 00\n";
  }
  const LogVerdict result = judged(log);
  EXPECT_EQ(result.lines.broken, 0U);
  EXPECT_LE(result.verdict.first, result.verdict.last);
  EXPECT_EQ(judged(" (9999-12-31 23:59:59.9) can0  205   [2]  0F 00\n").lines.broken, 1U);
  EXPECT_EQ(judged(" (2026-12-31 23:59:4000000000.9) can0  205   [2]  0F 00\n").lines.broken, 1U);
}

TEST(ALogWithDates, GoesOnOverTheEndOfAMonthAndOfAYear) {
  for (const auto& [before, after] :
       {std::pair("2025-12-31", "2026-01-01"), std::pair("2025-02-28", "2025-03-01"),
        std::pair("2024-02-28", "2024-02-29"), std::pair("2025-04-30", "2025-05-01")}) {
    const LogVerdict result =
        judged(" (" + std::string(before) + " 23:59:59.5) can0  185   [2]  37 02\n (" +
               std::string(after) + " 00:00:00.5) can0  185   [2]  37 02\n");
    EXPECT_EQ(result.lines.backwards, 0U) << after;
    EXPECT_EQ(result.lines.broken, 0U) << after;
    EXPECT_EQ(result.verdict.last - result.verdict.first, 1s) << after;
  }
}

TEST(ALogWithDates, HasNoDayThatTheCalendarDoesNotHave) {
  for (const char* const time :
       {"2025-02-29 08:00:00.5", "2025-00-10 08:00:00.5", "2025-01-10 24:00:00.5",
        "2025-01-10 08:60:00.5", "1969-12-31 08:00:00.5"}) {
    const std::string line = " (" + std::string(time) + ") can0  185   [2]  37 02\n";
    EXPECT_EQ(judged(line).lines.broken, 1U) << time;
  }
}

TEST(AnAscWithRelativeTimes, EndsWhereTimeEnds) {
  std::string log = "base hex  timestamps relative\n";
  for (int i = 0; i < 5; ++i) log += "4000000000.0 1  185  Rx  d 2 37 02\n";
  EXPECT_EQ(judged(log).lines.broken, 4U) << "the first one fits";
}

// RPDO 1 has the controlword, RPDO 2 the target; both wait for SYNC, so their order does not
// matter.
std::vector<std::string> synchronous_move(std::uint8_t type) {
  LoggedNode node;
  node.map(1, {0x60400010}, type);
  node.map(2, {0x607A0020, 0x60810020}, type);
  node.nmt(0x01);
  node.write(objects::kMode, kProfilePosition, 1);
  node.step(5);
  const auto cycle = [&node](std::uint16_t word, std::int32_t target) {
    node.word(word);
    node.pdo(2, {{target, 4}, {1'000, 4}});
    node.sync();
    node.step(10);
  };
  for (const std::uint16_t word : {controlwords::kShutdown, controlwords::kSwitchOn, kEnabled}) {
    cycle(word, 0);
  }
  cycle(0x001F, 500);
  cycle(0x000F, 500);
  for (int i = 0; i < 100; ++i) cycle(0x000F, 500);
  cycle(0x001F, 0);
  cycle(0x000F, 0);
  for (int i = 0; i < 100; ++i) cycle(0x000F, 0);
  cycle(0x0006, 0);
  return rules_in(node.log());
}

TEST(SynchronousPdos, AreJudgedAtTheirSync) {
  EXPECT_THAT(synchronous_move(1), IsEmpty());
  EXPECT_THAT(synchronous_move(255), Contains("handshake-3"));
}

TEST(SynchronousPdos, AreJudgedAtTheEndWhereNoSyncCame) {
  LoggedNode node;
  node.map(1, {0x60400010}, 1);
  node.nmt(0x01);
  for (int i = 0; i < 100; ++i) {
    node.word(0x0006);
    node.step(20);
  }
  EXPECT_THAT(rules_in(node.log()), Contains("sync-2"));
}

std::string heartbeats_of_a_master(const std::string& before) {
  std::string log = before;
  for (int i = 0; i < 20; ++i) {
    char line[64];
    std::snprintf(line, sizeof(line), "(%010d.%06d) can0 70A#05\n", 100 + i * 95 / 1000,
                  i * 95 % 1000 * 1000);
    log += line;
  }
  return log;
}

TEST(AConsumerOfHeartbeats, ThatWasSwitchedOffOrRestartedWaitsForNone) {
  LoggedNode node;
  node.enable(kProfilePosition);
  node.disable();
  node.write({0x1016, 1}, 0x000A0064, 4);
  EXPECT_THAT(rules_in(heartbeats_of_a_master(node.log())), Contains("supervision-4"));
  const std::string restarted = node.log() + "(0000000050.000000) can0 705#00\n";
  EXPECT_THAT(rules_in(heartbeats_of_a_master(restarted)), IsEmpty());
  node.write({0x1016, 1}, 0, 4);
  EXPECT_THAT(rules_in(heartbeats_of_a_master(node.log())), IsEmpty());
}

// The sum of this COB-ID and the node id wraps around: RPDO 1 no longer has 205h.
TEST(ADataSheetWithTheHighestNumber, TakesRpdo1AwayFromItsIdentifier) {
  std::string text = canopen::electronic_data_sheet({});
  const std::size_t at = text.find("DefaultValue=", text.find("[1400sub1]"));
  text.replace(at, text.find('\n', at) - at, "DefaultValue=$NODEID+9223372036854775807");
  const canopen::DataSheet sheet = canopen::read_data_sheet(text);
  const std::string log = session(false);
  std::uint64_t frames_of_rpdo_1 = 0;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" 205#") != std::string::npos) ++frames_of_rpdo_1;
  }
  ASSERT_GT(frames_of_rpdo_1, 0U);
  EXPECT_EQ(judged(log).frames.foreign, 0U);
  EXPECT_EQ(judged(log, {.sheet = &sheet}).frames.foreign, frames_of_rpdo_1);
}

}  // namespace
}  // namespace vdrive::judge
