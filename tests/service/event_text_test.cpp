// SPDX-License-Identifier: Apache-2.0
// Events as text and as a line of the log.
#include "publish/event_text.hpp"

#include "vdrive/event_kind.hpp"

#include <gtest/gtest.h>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

TEST(EventText, HasWordsForEveryKindOfTheContract) {
  for (const EventKindRow& row : kEventKinds) {
    const auto number = static_cast<std::uint32_t>(row.kind);
    const std::string words = words_of({.kind = msg::EventKind{number}});
    EXPECT_FALSE(words.empty()) << row.name;
    EXPECT_NE(words, "event " + std::to_string(number)) << row.name;
  }
  const auto next = static_cast<std::uint32_t>(kEventKinds.size()) + 1;
  EXPECT_EQ(words_of({.kind = msg::EventKind{next}}), "event " + std::to_string(next));
}

TEST(EventLine, HasKeysAndValuesAndTheTextLast) {
  EXPECT_EQ(
      log_line(3,
               {.kind = msg::EventKind::master_lost,
                .axis = 7,
                .session = 0x1234,
                .code = 112,
                .tick = 99,
                .detail = LostAxes{1, 112}},
               0),
      "event=master_lost bench=3 tick=99 axis=7 session=0x0000000000001234 code=0x0070 "
      "suppressed=0 "
      "text=\"axis 7: nothing was received from session 0x0000000000001234 for 112 ms; 1 axis "
      "lost its master\"");
  EXPECT_EQ(log_line(3, {.kind = msg::EventKind::fault, .axis = 7, .code = 0x8130, .tick = 99}, 21),
            "event=fault bench=3 tick=99 axis=7 code=0x8130 suppressed=21 text=\"axis 7: fault "
            "0x8130\"");
}

// 500 ppm of a second are 0.5 ms, so 10 s take 20,000 s.
TEST(EventWords, DescribeAStepOfTheWallClockAndItsCorrection) {
  EXPECT_EQ(words_of({.kind = msg::EventKind::wall_clock,
                      .code = 1,
                      .detail = std::chrono::microseconds{10s}}),
            "the wall clock was changed: it is 10 s ahead of drive time; drive time is adjusted by "
            "500 ppm for about 20000 s");
  EXPECT_EQ(words_of({.kind = msg::EventKind::wall_clock,
                      .code = 1,
                      .detail = std::chrono::microseconds{-1'500ms}}),
            "the wall clock was changed: it is 1.5 s behind drive time; drive time is adjusted by "
            "500 ppm for about 3000 s");
  EXPECT_EQ(words_of({.kind = msg::EventKind::wall_clock,
                      .code = 2,
                      .detail = std::chrono::microseconds{10s}}),
            "the wall clock was changed: it is 10 s ahead of drive time; the tick number jumps");
}

TEST(EventWords, SayHowLateOneTickWasAndTheWorstOfSeveral) {
  EXPECT_EQ(words_of({.kind = msg::EventKind::tick_overrun, .detail = Overruns{1, 1'203us, 0ms}}),
            "tick ended 1203 us late");
  EXPECT_EQ(
      words_of({.kind = msg::EventKind::tick_overrun, .detail = Overruns{412, 5'120us, 8'000ms}}),
      "412 ticks in 8 s ended late, by up to 5120 us");
}

TEST(EventWords, NameTheSessionThatStoppedAnAxisAndItsOwner) {
  EventRecord stop{.kind = msg::EventKind::stopped,
                   .axis = 2,
                   .session = 0xB0B,
                   .code = 0x0002,
                   .detail = Label{0xA11CE}};
  EXPECT_EQ(
      words_of(stop),
      "axis 2: quick stop by session 0x0000000000000b0b; session 0x00000000000a11ce keeps control");
  stop.code = 0x013F;  // bit 8
  stop.session = 0;
  EXPECT_EQ(
      words_of(stop),
      "axis 2: halted by a client without a session; session 0x00000000000a11ce keeps control");
}

TEST(EventWords, NameTheStepperThatLeavesTheClock) {
  EXPECT_EQ(words_of({.kind = msg::EventKind::clock_changed,
                      .session = 0xA11CE,
                      .code = wire::number(msg::RequestKind::leave_clock),
                      .detail = StepperRemoval::left}),
            "session 0x00000000000a11ce left the clock");
}

TEST(EventLine, NamesEveryKindOfEvent) {
  for (std::uint32_t kind = wire::number(msg::EventKind::state_changed);
       kind <= wire::number(msg::EventKind::stopped); ++kind) {
    EXPECT_EQ(log_line(1, {.kind = msg::EventKind{kind}}, 0).find("unknown"), std::string::npos)
        << kind;
  }
}

}  // namespace
}  // namespace vdrive::service
