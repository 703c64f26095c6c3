// SPDX-License-Identifier: Apache-2.0
// Which benches are present, judged by the age of their samples and by the participants on the bus.
#include "presence/directory.hpp"

#include "bench_messages.hpp"
#include "vdrive/wire/local_bus.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive_messages_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;
using testing::SizeIs;

TEST(Directory, NamesTheRunThatWasHeardLastAndWhetherItAnnouncedItsEnd) {
  Directory sut(by_age());
  EXPECT_EQ(sut.newest_run(1), (BenchKey{1, 0})) << "of a bench that nobody knows";
  auto message = description(1, 10);
  sut.on_description(message, kSource, kStart);
  sut.on_description(description(1, 9), kSource, kStart + 1s);
  EXPECT_EQ(sut.newest_run(1), (BenchKey{1, 9}));
  EXPECT_FALSE(sut.is_offline({1, 10}));
  message.alive = false;
  sut.on_description(message, kSource, kStart + 2s);
  EXPECT_EQ(sut.newest_run(1), (BenchKey{1, 10}));
  EXPECT_TRUE(sut.is_offline({1, 10}));
  EXPECT_EQ(sut.age({1, 10}, kStart + 2s), std::nullopt) << "a description is no sample";
}

TEST(Directory, ListsABenchAfterItsDescriptionAndItsState) {
  Directory sut(by_age());
  sut.on_description(description(1, 10), kSource, kStart);
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

class DirectoryOnABus : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<wire::Participant> join(wire::Role role,
                                                        const std::string& name) const {
    wire::NetworkSettings settings;
    settings.role = role;
    settings.bus = bus_;
    return wire::make_participant(settings, name);
  }

  std::shared_ptr<wire::LocalBus> bus_ = std::make_shared<wire::LocalBus>();
  std::unique_ptr<wire::Participant> client_ = join(wire::Role::client, "vdrive client");
  std::unique_ptr<wire::Participant> service_ = join(wire::Role::service, "vdrived 1");
  Directory sut_{client_->presence()};
};

TEST_F(DirectoryOnABus, ListsABenchFromItsDescriptionUntilItsSenderLeaves) {
  sut_.on_description(description(1, 10), service_->source(), kStart);
  const auto later = kStart + 1h;
  ASSERT_THAT(sut_.present(later), SizeIs(1)) << "no age judges it";
  EXPECT_EQ(sut_.present(later)[0].info.sample_age, 0ms);
  EXPECT_TRUE(sut_.is_alive({1, 10}, 1ms, later));
  service_.reset();
  EXPECT_THAT(sut_.present(later), IsEmpty());
  EXPECT_FALSE(sut_.is_alive({1, 10}, 1h, later));
  EXPECT_EQ(sut_.age({1, 10}, later), std::nullopt);
}

// Only the state has the rate. A session that did not wait for it would assume that a paused bench
// runs.
TEST_F(DirectoryOnABus, ListsABenchInRealTimeAfterItsState) {
  msg::BenchDescription in_real_time = description(1, 10);
  in_real_time.clock_mode = msg::ClockMode::realtime;
  sut_.on_description(in_real_time, service_->source(), kStart);
  EXPECT_THAT(sut_.present(kStart), IsEmpty());
  msg::BenchState paused = state(1, 10);
  paused.rate = 0.0;
  sut_.on_state(paused, kStart);
  ASSERT_THAT(sut_.present(kStart + 10s), SizeIs(1));
  EXPECT_EQ(sut_.present(kStart + 10s)[0].info.rate, 0.0);
}

TEST(Directory, StoresTheUnitOfAnAxis) {
  msg::BenchDescription message = description(1, 10);
  message.axes.front().unit_kind = msg::UnitKind::linear;
  message.axes.front().unit_name = "mm";
  message.axes.front().unit_size = 1'000.0;
  Directory sut(by_age());
  sut.on_description(message, kSource, kStart);
  sut.on_state(state(1, 10), kStart);
  ASSERT_THAT(sut.present(kStart), SizeIs(1));
  EXPECT_EQ(sut.present(kStart)[0].info.axes.at(0).unit,
            (Unit{.kind = UnitKind::linear, .name = "mm", .size = 1'000.0}));
}

TEST(Directory, WaitsForEveryPartOfADescription) {
  Directory sut(by_age());
  sut.on_state(state(1, 10), kStart);
  sut.on_description(description(1, 10, 1, 2), kSource, kStart);
  EXPECT_THAT(sut.present(kStart), IsEmpty());
  sut.on_description(description(1, 10, 0, 2), kSource, kStart);
  ASSERT_THAT(sut.present(kStart), SizeIs(1));
  EXPECT_THAT(sut.present(kStart)[0].info.axes, SizeIs(2));
}

TEST(Directory, RemovesABenchThatSendsNothingForThreeHundredMilliseconds) {
  Directory sut(by_age());
  sut.on_description(description(1, 10), kSource, kStart);
  sut.on_state(state(1, 10), kStart);
  EXPECT_THAT(sut.present(kStart + 299ms), SizeIs(1));
  EXPECT_THAT(sut.present(kStart + 300ms), IsEmpty());
  sut.note_sample({1, 10}, 1, kStart + 400ms);
  EXPECT_THAT(sut.present(kStart + 500ms), SizeIs(1));
}

TEST(Directory, APauseOfThisProgramMakesNoSampleOlder) {
  wire::PresenceByAge presence{{}};
  Directory sut(presence);
  sut.on_description(description(1, 10), kSource, presence.running_time(kStart));
  sut.on_state(state(1, 10), presence.running_time(kStart));
  const auto after = presence.running_time(kStart + 4s);
  EXPECT_TRUE(sut.is_alive({1, 10}, 1500ms, after));
  EXPECT_TRUE(sut.find(1, after)) << "it is there";
  EXPECT_EQ(sut.age({1, 10}, after), wire::PresenceByAge::kPulse);
  EXPECT_FALSE(sut.is_alive({1, 10}, 1500ms, after + 2s)) << "a silence while the program runs";
}

TEST(Directory, GivesTheAgeOfTheNewestSampleWithAndWithoutPassingTicks) {
  Directory sut(by_age());
  sut.on_description(description(1, 10), kSource, kStart);
  sut.on_state(state(1, 10, 7), kStart);
  EXPECT_EQ(sut.present(kStart + 40ms).at(0).info.sample_age, 40ms);
  sut.on_state(state(1, 10, 7), kStart + 50ms);  // the same tick: its time stands still
  EXPECT_EQ(sut.present(kStart + 52ms).at(0).info.sample_age, 2ms);
  sut.note_sample({1, 10}, 8, kStart + 60ms);
  EXPECT_EQ(sut.present(kStart + 60ms).at(0).info.sample_age, 0ms);
}

TEST(Directory, RemovesABenchThatGoesOfflineAtOnce) {
  Directory sut(by_age());
  sut.on_description(description(1, 10), kSource, kStart);
  sut.on_state(state(1, 10), kStart);
  msg::BenchDescription goodbye = description(1, 10);
  goodbye.alive = false;
  sut.on_description(goodbye, kSource, kStart);
  EXPECT_THAT(sut.present(kStart), IsEmpty());
  EXPECT_FALSE(sut.is_alive({1, 10}, 1s, kStart));
}

TEST(Directory, ExpectsMoreOfABenchThatIsKnownInPart) {
  Directory sut(by_age());
  EXPECT_FALSE(sut.expects_more(kStart));
  sut.on_description(description(1, 10), kSource, kStart);
  EXPECT_TRUE(sut.expects_more(kStart)) << "described, no sample";
  EXPECT_EQ(sut.described(), 1U);
  sut.on_state(state(1, 10), kStart);
  EXPECT_FALSE(sut.expects_more(kStart)) << "it is there";
  sut.on_state(state(2, 20), kStart);
  EXPECT_TRUE(sut.expects_more(kStart)) << "a sample, no description";
  EXPECT_EQ(sut.described(), 1U);
  sut.on_description(description(2, 20, 0, 2), kSource, kStart);
  EXPECT_TRUE(sut.expects_more(kStart)) << "half of its description";
  EXPECT_FALSE(sut.expects_more(kStart + 300ms)) << "it fell silent";
}

TEST(Directory, TreatsARestartAsAnotherRun) {
  Directory sut(by_age());
  sut.on_description(description(1, 10), kSource, kStart);
  sut.on_state(state(1, 10), kStart);
  sut.on_description(description(1, 11), kSource, kStart);
  sut.on_state(state(1, 11), kStart + 1s);
  EXPECT_FALSE(sut.is_alive({1, 10}, 1s, kStart + 1s));
  ASSERT_TRUE(sut.find(1, kStart + 1s).has_value());
  EXPECT_EQ(sut.find(1, kStart + 1s)->info.incarnation, 11U);
}

TEST(Directory, PrefersTheLowerIncarnationOfTwoBenchesWithOneNumber) {
  Directory sut(by_age());
  for (const std::uint64_t incarnation : {11U, 10U}) {
    sut.on_description(description(1, incarnation), kSource, kStart);
    sut.on_state(state(1, incarnation), kStart);
  }
  ASSERT_THAT(sut.present(kStart), SizeIs(1));
  EXPECT_EQ(sut.present(kStart)[0].info.incarnation, 10U);
}

TEST(Directory, CountsTheStartsOfTheNetworkProcessOfABench) {
  Directory sut(by_age());
  sut.on_description(description(1, 10), kSource, kStart);
  sut.note_sample({1, 10}, 1, kStart);
  EXPECT_EQ(sut.find(1, kStart)->info.wire_starts, 0U) << "no state has arrived";
  for (const std::uint64_t starts : {1U, 4U}) {
    msg::BenchState message = state(1, 10);
    message.wire_starts = starts;
    sut.on_state(message, kStart);
    EXPECT_EQ(sut.find(1, kStart)->info.wire_starts, starts);
  }
}

TEST(Directory, HasTheValueOfEachFigureOfABench) {
  Directory sut(by_age());
  sut.on_description(description(1, 10), kSource, kStart);
  sut.note_sample({1, 10}, 1, kStart);
  EXPECT_EQ(sut.find(1, kStart)->info.figures, all_figures()) << "no state has arrived";
  msg::BenchState message = state(1, 10);
  std::vector<Figure> expected;
  wire::for_each_figure<msg::BenchState>(
      [&]<typename Value>(const wire::Member<msg::BenchState, Value>& member) {
        message.*member.pointer = static_cast<Value>(expected.size() + 1);
        expected.push_back({.name = member.name,
                            .value = message.*member.pointer,
                            .unit = member.unit,
                            .help = member.help,
                            .is_counter = member.figure == wire::FigureKind::counter,
                            .is_headline = member.is_headline});
      });
  sut.on_state(message, kStart);
  EXPECT_FALSE(expected.empty());
  EXPECT_EQ(sut.find(1, kStart)->info.figures, expected);
}

TEST(Directory, SurvivesInvalidMessages) {
  Directory sut(by_age());
  msg::BenchDescription nonsense = description(1, 10, 5, 0);
  nonsense.period_us = 0;
  nonsense.status_every_ticks = 0;
  nonsense.clock_mode = static_cast<msg::ClockMode>(99);
  sut.on_description(nonsense, kSource, kStart);
  sut.on_state(state(1, 10), kStart);
  EXPECT_THAT(sut.present(kStart), IsEmpty());
  EXPECT_EQ(sut.tick({2, 2}), 0U);
}

// Announces runs with invented numbers, as if another service had started for each.
void announce(Directory& sut, std::uint64_t first, std::size_t count,
              Directory::Clock::time_point now, std::uint16_t parts = 1) {
  for (std::uint64_t run = first; run < first + count; ++run) {
    sut.on_state(state(2, run), now);
    for (std::uint16_t part = 0; part < parts; ++part) {
      sut.on_description(description(2, run, part, parts), kSource, now);
    }
  }
}

TEST(Directory, KeepsAtMostAThousandRunsAndDropsTheLongestSilentOne) {
  Directory sut(by_age());
  announce(sut, 1, kMostRuns, kStart);
  announce(sut, 1, 1, kStart + 1s);
  sut.on_state(state(1, 10), kStart + kForgetAfter);
  sut.on_description(description(1, 10), kSource, kStart + kForgetAfter);
  const auto runs = sut.seen_runs(kStart + kForgetAfter);
  EXPECT_THAT(runs, SizeIs(kMostRuns));
  EXPECT_EQ(runs[0].key, (BenchKey{1, 10})) << "the new one";
  EXPECT_EQ(runs[1].key, (BenchKey{2, 1})) << "received once more than the others";
  EXPECT_EQ(runs[2].key, (BenchKey{2, 3})) << "in place of the first of the silent ones";
}

TEST(Directory, KeepsAPresentBenchDuringAFloodOfOtherBenches) {
  Directory sut(by_age());
  sut.on_description(description(1, 10), kSource, kStart);
  sut.on_state(state(1, 10), kStart);
  announce(sut, 1, 3 * kMostRuns, kStart + 100ms);
  EXPECT_TRUE(sut.find(1, kStart + 100ms).has_value());
  EXPECT_THAT(sut.seen_runs(kStart + 100ms), SizeIs(kMostRuns));
}

TEST(Directory, KeepsAtMostFourThousandPartsOfDescriptions) {
  Directory sut(by_age());
  constexpr std::uint16_t kParts = 256;
  announce(sut, 1, kMostParts / kParts + 1, kStart, kParts);
  EXPECT_THAT(sut.present(kStart), SizeIs(1)) << "the first one is whole";
  EXPECT_EQ(sut.present(kStart)[0].info.axes.size(), kParts);
  sut.on_state(state(1, 10), kStart);
  sut.on_description(description(1, 10), kSource, kStart);
  EXPECT_EQ(sut.find(1, kStart), std::nullopt) << "no room for its description";
  const auto later = kStart + kForgetAfter;
  sut.on_state(state(1, 10), later);
  sut.on_description(description(1, 10), kSource, later);
  EXPECT_TRUE(sut.find(1, later).has_value()) << "in place of one that is silent";
}

// A state, then frames after a jump over 9,000 ticks, one of them late.
TEST(Directory, CountsDriveTimeWithoutTheTicksThatTheNumberJumpedOver) {
  Directory sut(by_age());
  constexpr BenchKey kRun{1, 10};
  EXPECT_EQ(sut.driven_tick(kRun), std::nullopt);
  sut.on_description(description(1, 10), kSource, kStart);
  EXPECT_EQ(sut.driven_tick(kRun), std::nullopt) << "no sample has come";
  msg::BenchState first = state(1, 10, 500);
  first.skipped_ticks = 20;
  sut.on_state(first, kStart);
  EXPECT_EQ(sut.driven_tick(kRun), 500U);
  sut.note_time(kRun, {9'503, 9'020});
  EXPECT_EQ(sut.driven_tick(kRun), 503U);
  sut.note_time(kRun, {502, 20});
  EXPECT_EQ(sut.driven_tick(kRun), 503U);
  sut.note_sample(kRun, 99'999, kStart);
  EXPECT_EQ(sut.driven_tick(kRun), 503U) << "an answer does not say what was skipped";
  sut.note_time(kRun, {9'510, 9'020});
  EXPECT_EQ(sut.driven_tick(kRun), 510U);
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
