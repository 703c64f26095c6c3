// SPDX-License-Identifier: Apache-2.0
// Logs with the times, parameters and data sheets that nobody would write on purpose.
#include "judge/axis_track.hpp"
#include "judge/judged_drive.hpp"
#include "judge/logged_node.hpp"
#include "log/bus_log.hpp"
#include "node/data_sheet_reader.hpp"
#include "node/electronic_data_sheet.hpp"
#include "vdrive/cia402/controlword.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <sstream>
#include <string>
#include <utility>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::IsEmpty;
using testing::Not;

LogVerdict judged_log(const std::string& log, const DecoderSettings& settings = {}) {
  std::istringstream stream(log);
  return judge_bus_log(stream, settings);
}

std::vector<std::string> rules_of(const std::string& log, const DecoderSettings& settings = {}) {
  return broken_rules(judged_log(log, settings).verdict);
}

/// The times of `log` so many seconds later.
std::string later(const std::string& log, long seconds) {
  std::string text;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    char number[16];
    std::snprintf(number, sizeof(number), "%010ld", std::stol(line.substr(1, 10)) + seconds);
    text += "(" + std::string(number) + line.substr(11) + "\n";
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
  const LogVerdict result = judged_log(later(session(false), 5'000) + session(true));
  EXPECT_THAT(broken_rules(result.verdict), IsEmpty());
  EXPECT_EQ(result.lines.backwards, 1U);
  EXPECT_GT(result.verdict.last - result.verdict.first, 200ms);
}

// The log is the same with a clock that is set back by 10 ms in a move.
TEST(ALogWhoseClockGoesBackOnce, KeepsWhatItKnewWhereTheStepIsShort) {
  const std::string log = session(true);
  const std::size_t half = log.find('\n', log.size() / 2) + 1;
  const LogVerdict result = judged_log(later(log.substr(0, half), 1) + log.substr(half));
  EXPECT_THAT(broken_rules(result.verdict), IsEmpty());
  EXPECT_EQ(result.lines.backwards, 1U);
}

TEST(ALogWhoseClockJumps, NeverLeavesTheRangeOfTimes) {
  std::string log;
  for (int i = 0; i < 10; ++i) {
    log += "(3999999999.0) can0 185#3702\n(0.0) can0 205#0F00\n";
    log += " (2089-12-31 23:59:59.9) can0  205   [2]  0F 00\n";
  }
  const LogVerdict result = judged_log(log);
  EXPECT_EQ(result.lines.broken, 0U);
  EXPECT_LE(result.verdict.first, result.verdict.last);
  EXPECT_EQ(judged_log(" (9999-12-31 23:59:59.9) can0  205   [2]  0F 00\n").lines.broken, 1U);
  EXPECT_EQ(judged_log(" (2026-12-31 23:59:4000000000.9) can0  205   [2]  0F 00\n").lines.broken,
            1U);
}

TEST(ALogWithDates, GoesOnOverTheEndOfAMonthAndOfAYear) {
  for (const auto& [before, after] :
       {std::pair("2025-12-31", "2026-01-01"), std::pair("2025-02-28", "2025-03-01"),
        std::pair("2024-02-28", "2024-02-29"), std::pair("2025-04-30", "2025-05-01")}) {
    const LogVerdict result =
        judged_log(" (" + std::string(before) + " 23:59:59.5) can0  185   [2]  37 02\n (" +
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
    EXPECT_EQ(judged_log(line).lines.broken, 1U) << time;
  }
}

TEST(AnAscWithRelativeTimes, EndsWhereTimeEnds) {
  std::string log = "base hex  timestamps relative\n";
  for (int i = 0; i < 5; ++i) log += "4000000000.0 1  185  Rx  d 2 37 02\n";
  EXPECT_EQ(judged_log(log).lines.broken, 4U) << "the first one fits";
}

// RPDO 1 has the controlword, RPDO 2 the target; both wait for SYNC, so their order does not count.
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
  return rules_of(node.log());
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
  EXPECT_THAT(rules_of(node.log()), Contains("sync-2"));
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
  EXPECT_THAT(rules_of(heartbeats_of_a_master(node.log())), Contains("supervision-4"));
  const std::string restarted = node.log() + "(0000000050.000000) can0 705#00\n";
  EXPECT_THAT(rules_of(heartbeats_of_a_master(restarted)), IsEmpty());
  node.write({0x1016, 1}, 0, 4);
  EXPECT_THAT(rules_of(heartbeats_of_a_master(node.log())), IsEmpty());
}

TEST(ADataSheetWithTheHighestNumber, DoesNoHarm) {
  std::string text = canopen::electronic_data_sheet({});
  const std::size_t at = text.find("DefaultValue=", text.find("[1400sub1]"));
  text.replace(at, text.find('\n', at) - at, "DefaultValue=$NODEID+9223372036854775807");
  const canopen::DataSheet sheet = canopen::read_data_sheet(text);
  EXPECT_GT(judged_log(session(false), {.sheet = &sheet}).frames.frames, 0U);
}

}  // namespace
}  // namespace vdrive::judge
