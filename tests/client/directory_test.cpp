// SPDX-License-Identifier: Apache-2.0
// Who is there: judged by the age of samples.
#include "directory.hpp"

#include "bench_messages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;
using testing::SizeIs;

TEST(Directory, KnowsABenchOnceItIsDescribedAndHeard) {
  Directory sut;
  sut.on_description(description(1, 10), kSource);
  EXPECT_THAT(sut.present(kStart), IsEmpty()) << "a description comes from the history";
  sut.on_state(state(1, 10, 7), kStart);
  const auto benches = sut.present(kStart);
  ASSERT_THAT(benches, SizeIs(1));
  EXPECT_EQ(benches[0].info.tick, 7U);
  EXPECT_EQ(benches[0].info.clock_mode, ClockMode::lockstep);
  EXPECT_EQ(benches[0].source, kSource);
  ASSERT_THAT(benches[0].info.axes, SizeIs(1));
  EXPECT_EQ(benches[0].info.axes[0].id, (AxisId{1, 1}));
}

TEST(Directory, WaitsForEveryPartOfADescription) {
  Directory sut;
  sut.on_state(state(1, 10), kStart);
  sut.on_description(description(1, 10, 1, 2), kSource);
  EXPECT_THAT(sut.present(kStart), IsEmpty());
  sut.on_description(description(1, 10, 0, 2), kSource);
  ASSERT_THAT(sut.present(kStart), SizeIs(1));
  EXPECT_THAT(sut.present(kStart)[0].info.axes, SizeIs(2));
}

TEST(Directory, ForgetsABenchThatIsSilentForThreeHundredMilliseconds) {
  Directory sut;
  sut.on_description(description(1, 10), kSource);
  sut.on_state(state(1, 10), kStart);
  EXPECT_THAT(sut.present(kStart + 299ms), SizeIs(1));
  EXPECT_THAT(sut.present(kStart + 300ms), IsEmpty());
  sut.heard({1, 10}, 1, kStart + 400ms);
  EXPECT_THAT(sut.present(kStart + 500ms), SizeIs(1));
}

TEST(Directory, ForgetsABenchThatSaysGoodbyeAtOnce) {
  Directory sut;
  sut.on_description(description(1, 10), kSource);
  sut.on_state(state(1, 10), kStart);
  msg::BenchDescription goodbye = description(1, 10);
  goodbye.alive(false);
  sut.on_description(goodbye, kSource);
  EXPECT_THAT(sut.present(kStart), IsEmpty());
  EXPECT_FALSE(sut.is_alive({1, 10}, 1s, kStart));
}

TEST(Directory, TakesARestartForAnotherRun) {
  Directory sut;
  sut.on_description(description(1, 10), kSource);
  sut.on_state(state(1, 10), kStart);
  sut.on_description(description(1, 11), kSource);
  sut.on_state(state(1, 11), kStart + 1s);
  EXPECT_FALSE(sut.is_alive({1, 10}, 1s, kStart + 1s));
  ASSERT_TRUE(sut.find(1, kStart + 1s).has_value());
  EXPECT_EQ(sut.find(1, kStart + 1s)->info.incarnation, 11U);
}

TEST(Directory, OfTwoWithOneNumberBelievesTheLowerIncarnation) {
  Directory sut;
  for (const std::uint64_t incarnation : {11U, 10U}) {
    sut.on_description(description(1, incarnation), kSource);
    sut.on_state(state(1, incarnation), kStart);
  }
  ASSERT_THAT(sut.present(kStart), SizeIs(1));
  EXPECT_EQ(sut.present(kStart)[0].info.incarnation, 10U);
}

TEST(Directory, SurvivesNonsense) {
  Directory sut;
  msg::BenchDescription nonsense = description(1, 10, 5, 0);
  nonsense.period_us(0);
  nonsense.status_every_ticks(0);
  nonsense.clock_mode(99);
  sut.on_description(nonsense, kSource);
  sut.on_state(state(1, 10), kStart);
  EXPECT_THAT(sut.present(kStart), IsEmpty());
  EXPECT_EQ(sut.tick({2, 2}), 0U);
}

TEST(AxisId, IsWrittenWithADot) {
  EXPECT_EQ(parse_axis_id("1.2"), (AxisId{1, 2}));
  EXPECT_EQ(to_string(AxisId{1, 2}), "1.2");
  for (const char* const text : {"", "1", "1.", ".2", "1.2.3", "x.1", "-1.2", "1.65536", "1. 2"}) {
    EXPECT_EQ(parse_axis_id(text), std::nullopt) << text;
  }
}

TEST(Ticks, AreRoundedUp) {
  EXPECT_EQ(ticks_of(20ms, 1000us), 20U);
  EXPECT_EQ(ticks_of(500us, 1000us), 1U);
  EXPECT_EQ(ticks_of(1001us, 1000us), 2U);
  EXPECT_EQ(ticks_of(1s, 125us), 8000U);
  EXPECT_EQ(ticks_of(0s, 1000us), 0U);
  EXPECT_EQ(ticks_of(-1s, 1000us), 0U);
}

}  // namespace
}  // namespace vdrive::client
