// SPDX-License-Identifier: Apache-2.0
#include "event_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::gateway {
namespace {

using client::Event;
using client::EventKind;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::uint64_t kTick = 50'000;

Event event_at(std::uint32_t bench, std::uint64_t tick) {
  Event event;
  event.bench = bench;
  event.tick = tick;
  return event;
}

std::vector<std::uint64_t> ticks(const EventLog& log, std::uint32_t bench) {
  std::vector<std::uint64_t> ticks;
  for (const Event& event : log.events(bench)) ticks.push_back(event.tick);
  return ticks;
}

TEST(EventLog, HasTheEventsOfEachBenchInTheirOrder) {
  EventLog log;
  log.add(event_at(1, kTick));
  log.add(event_at(2, kTick + 5));
  log.add(event_at(1, kTick + 7));
  EXPECT_THAT(ticks(log, 1), ElementsAre(kTick, kTick + 7));
  EXPECT_THAT(ticks(log, 2), ElementsAre(kTick + 5));
  EXPECT_THAT(ticks(log, 3), IsEmpty());
}

TEST(EventLog, ForgetsTheOldestEventOfABenchWithTooMany) {
  EventLog log;
  log.add(event_at(2, 1));
  for (std::uint64_t i = 0; i <= EventLog::kMostOfABench; ++i) log.add(event_at(1, i));
  ASSERT_EQ(log.events(1).size(), EventLog::kMostOfABench);
  EXPECT_EQ(log.events(1).front().tick, 1U);
  EXPECT_EQ(log.events(1).back().tick, EventLog::kMostOfABench);
  EXPECT_THAT(ticks(log, 2), ElementsAre(1)) << "the limit is that of one bench";
}

TEST(EventLog, KeepsAFaultAfterAFloodOfLateTicks) {
  EventLog log;
  const auto add = [&](std::uint64_t tick, EventKind kind) {
    Event event = event_at(1, tick);
    event.kind = kind;
    log.add(event);
  };
  add(1, EventKind::fault);
  add(2, EventKind::fault);
  // There is room for 1,022 overruns; each further one replaces the oldest overrun.
  for (std::uint64_t i = 0; i < 3 * EventLog::kMostOfABench; ++i) {
    add(10 + i, EventKind::tick_overrun);
  }
  const auto kept = log.events(1);
  ASSERT_EQ(kept.size(), EventLog::kMostOfABench);
  EXPECT_EQ(kept[0].tick, 1U);
  EXPECT_EQ(kept[1].tick, 2U);
  EXPECT_EQ(kept[2].tick, 10 + 2 * EventLog::kMostOfABench + 2);
  EXPECT_EQ(kept.back().tick, 10 + 3 * EventLog::kMostOfABench - 1);
}

TEST(EventLog, KeepsItsHistoryWhenASummaryOfEqualEventsComesLate) {
  EventLog log;
  for (const std::uint64_t tick : {kTick, kTick + 9'000}) log.add(event_at(1, tick));
  // A summary of equal events comes up to a second late, with the tick of the last of them. In
  // freerun, any number of ticks may have passed since.
  log.add(event_at(1, kTick + 1));
  log.add(event_at(1, 3));
  EXPECT_THAT(ticks(log, 1), ElementsAre(3, kTick, kTick + 1, kTick + 9'000));
}

TEST(EventLog, BeginsANewHistoryWithAnotherRunWhateverItsTicksAre) {
  EventLog log;
  log.add(event_at(1, kTick));
  Event of_next_run = event_at(1, kTick + 1);
  of_next_run.incarnation = 7;
  log.add(of_next_run);
  EXPECT_THAT(ticks(log, 1), ElementsAre(kTick + 1));
}

TEST(EventLog, ForgetsTheBenchThatWasQuietLongestAmongTooMany) {
  EventLog log;
  for (std::uint32_t bench = 1; bench <= EventLog::kMostBenches; ++bench) {
    log.add(event_at(bench, bench));
  }
  log.add(event_at(1, kTick));
  log.add(event_at(EventLog::kMostBenches + 1, 1));
  EXPECT_THAT(ticks(log, 2), IsEmpty());
  EXPECT_THAT(ticks(log, 1), ElementsAre(1, kTick));
  EXPECT_THAT(ticks(log, 3), ElementsAre(3));
}

TEST(EventLog, AnswersWithWhatPeopleReadAndWithWhatProgramsCompare) {
  EventLog log;
  Event event = event_at(1, kTick);
  event.axis = 4;
  event.kind = EventKind::fault;
  event.code = 0x8611;
  event.suppressed = 2;
  event.text = "fault 0x8611";
  log.add(event);
  const Json answer = call_events(log, {{"bench", 1}}).fields;
  EXPECT_EQ(answer["events"], Json::array({{{"tick", kTick},
                                            {"axis", 4},
                                            {"kind", "fault"},
                                            {"level", 4},
                                            {"code", 0x8611},
                                            {"message", "fault 0x8611 (2 more suppressed)"}}}));
  EXPECT_EQ(call_events(log, {{"bench", 2}}).fields["events"], Json::array());
}

TEST(EventLog, RefusesARequestWithoutABench) {
  const EventLog log;
  for (const Json& request : {Json::object(), Json{{"bench", "x"}}, Json{{"bench", -1}}}) {
    try {
      (void)call_events(log, request);
      FAIL() << request;
    } catch (const ProtocolError& error) {
      EXPECT_THAT(error.what(), HasSubstr("'bench'"));
    }
  }
}

}  // namespace
}  // namespace vdrive::gateway
