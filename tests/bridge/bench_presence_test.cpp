// SPDX-License-Identifier: Apache-2.0
#include "bench_presence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

namespace vdrive::bridge {
namespace {

using namespace std::chrono_literals;
using client::BenchInfo;
using client::ServiceNews;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr Presence::Clock::time_point kPresenceBegin{1h};

BenchInfo bench_info(std::uint32_t number, std::uint64_t incarnation = 1,
                     const std::string& axis = "x") {
  BenchInfo info;
  info.number = number;
  info.incarnation = incarnation;
  info.axes.emplace_back().id = {number, 1};
  info.axes.back().name = axis;
  return info;
}

client::ServiceChange change_of(ServiceNews news, std::chrono::milliseconds silence = {}) {
  return {.bench = 1, .news = news, .silence = silence, .text = {}};
}

/// As the gateway has it: another run with the same axes continues.
Presence::Rules rules() {
  return {.continues = [](const BenchInfo& known, const BenchInfo& found) {
    return known.axes.front().name == found.axes.front().name;
  }};
}

std::vector<std::string> words(const std::vector<PresenceChange>& changes) {
  std::vector<std::string> list;
  for (const PresenceChange& change : changes) {
    constexpr std::array kWords{"came", "renewed", "replaced", "went"};
    list.push_back(kWords.at(static_cast<std::size_t>(change.kind)) + std::string(" ") +
                   std::to_string(change.bench));
  }
  return list;
}

TEST(Presence, ReportsABenchOnceWhenItComes) {
  Presence presence(rules());
  EXPECT_THAT(words(presence.take({bench_info(1), bench_info(2)}, kPresenceBegin)),
              ElementsAre("came 1", "came 2"));
  EXPECT_THAT(words(presence.take({bench_info(1), bench_info(2)}, kPresenceBegin)), IsEmpty());
  EXPECT_EQ(presence.all().size(), 2U);
  EXPECT_FALSE(presence.find(3));
}

TEST(Presence, LeavesOutBenchesThatAreNotWantedOrHaveNoAxes) {
  Presence::Rules chosen = rules();
  chosen.wanted = {2, 3};
  Presence presence(std::move(chosen));
  BenchInfo empty = bench_info(3);
  empty.axes.clear();
  EXPECT_THAT(words(presence.take({bench_info(1), bench_info(2), empty}, kPresenceBegin)),
              ElementsAre("came 2"));
}

TEST(Presence, RenewsABenchThatContinuesAsAnotherRun) {
  Presence presence(rules());
  (void)presence.take({bench_info(1)}, kPresenceBegin);
  presence.note(change_of(ServiceNews::fell_silent), kPresenceBegin);
  EXPECT_FALSE(presence.find(1)->is_alive);
  EXPECT_THAT(words(presence.take({bench_info(1, 2)}, kPresenceBegin)), ElementsAre("renewed 1"));
  EXPECT_TRUE(presence.find(1)->is_alive) << "the report of its silence is about the run before";
  EXPECT_EQ(presence.find(1)->info.incarnation, 2U);
}

TEST(Presence, ReplacesABenchWithOtherAxes) {
  Presence presence(rules());
  (void)presence.take({bench_info(1)}, kPresenceBegin);
  EXPECT_THAT(words(presence.take({bench_info(1, 2, "y")}, kPresenceBegin)),
              ElementsAre("replaced 1", "came 1"));
}

TEST(Presence, KeepsASilentBenchAsLongAsItsPatience) {
  Presence presence(rules());
  (void)presence.take({bench_info(1)}, kPresenceBegin);
  EXPECT_THAT(words(presence.take({}, kPresenceBegin + Presence::kUsualPatience)), IsEmpty());
  EXPECT_THAT(words(presence.take({}, kPresenceBegin + Presence::kUsualPatience + 1ms)),
              ElementsAre("went 1"));
  EXPECT_THAT(words(presence.take({bench_info(1)}, kPresenceBegin + 2min)), ElementsAre("came 1"));
}

TEST(Presence, CountsThePatienceFromTheNewestSample) {
  Presence presence(rules());
  BenchInfo old = bench_info(1);
  old.sample_age = 200ms;
  (void)presence.take({old}, kPresenceBegin);
  EXPECT_EQ(presence.find(1)->newest_sample, kPresenceBegin - 200ms);
  presence.refresh({bench_info(1)}, kPresenceBegin + 30s);
  EXPECT_THAT(words(presence.take({}, kPresenceBegin + 80s)), IsEmpty());
  presence.note(change_of(ServiceNews::fell_silent, 70s), kPresenceBegin + 80s);
  EXPECT_THAT(words(presence.take({}, kPresenceBegin + 80s)), ElementsAre("went 1"));
}

TEST(Presence, ForgetsABenchThatAnnouncedItsEndAtOnce) {
  Presence presence(rules());
  (void)presence.take({bench_info(1)}, kPresenceBegin);
  presence.note(change_of(ServiceNews::went_offline), kPresenceBegin);
  EXPECT_THAT(words(presence.take({}, kPresenceBegin)), ElementsAre("went 1"));
}

TEST(Presence, KeepsABenchThatStartsAgainAfterItAnnouncedItsEnd) {
  Presence presence(rules());
  (void)presence.take({bench_info(1)}, kPresenceBegin);
  presence.note(change_of(ServiceNews::went_offline), kPresenceBegin);
  EXPECT_THAT(words(presence.take({bench_info(1, 2)}, kPresenceBegin)), ElementsAre("renewed 1"));
}

TEST(Presence, RefreshesOnlyTheRunThatItKnows) {
  Presence presence(rules());
  (void)presence.take({bench_info(1)}, kPresenceBegin);
  BenchInfo later = bench_info(1);
  later.tick = 77;
  presence.refresh({later, bench_info(2)}, kPresenceBegin);
  EXPECT_EQ(presence.find(1)->info.tick, 77U);
  EXPECT_EQ(presence.all().size(), 1U) << "a bench comes by take()";
  presence.refresh({bench_info(1, 2)}, kPresenceBegin);
  EXPECT_EQ(presence.find(1)->info.incarnation, 1U) << "its readers would miss that it is renewed";
}

}  // namespace
}  // namespace vdrive::bridge
