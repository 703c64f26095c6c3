// SPDX-License-Identifier: Apache-2.0
#include "roster.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::bridge {
namespace {

using namespace std::chrono_literals;
using client::BenchInfo;
using client::ServiceNews;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

constexpr Roster::Clock::time_point kRosterBegin{1h};

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

/// Like the gateway, continues with another run that has the same axes. Records its calls.
struct RecordingHost final : BenchHost {
  bool continues(const BenchInfo& known, const BenchInfo& found) const override {
    return known.axes.front().name == found.axes.front().name;
  }

  std::optional<std::string> add(const BenchInfo& bench) override {
    if (refused.contains(bench.number)) return refused.at(bench.number);
    told.push_back("add " + std::to_string(bench.number));
    return std::nullopt;
  }

  void leave_out(const BenchInfo& bench, const std::string& reason) override {
    told.push_back("leave out " + std::to_string(bench.number) + ": " + reason);
  }

  void renew(const BenchInfo& bench) override {
    told.push_back("renew " + std::to_string(bench.number));
  }

  void remove(std::uint32_t bench, bool is_replaced) override {
    told.push_back((is_replaced ? "replace " : "remove ") + std::to_string(bench));
  }

  std::map<std::uint32_t, std::string> refused{};  ///< reasons by bench number
  std::vector<std::string> told{};
};

/// A roster with its host.
struct HostedRoster {
  explicit HostedRoster(std::vector<std::uint32_t> wanted = {}) : roster(host, std::move(wanted)) {}

  /// @return the calls of the host.
  std::vector<std::string> take(std::vector<BenchInfo> found,
                                Roster::Clock::time_point now = kRosterBegin) {
    const bool has_changed = roster.take(std::move(found), now);
    const bool is_told = std::ranges::any_of(host.told, [](const std::string& line) {
      return !line.starts_with("leave out");
    });
    EXPECT_EQ(has_changed, is_told);
    return std::exchange(host.told, {});
  }

  RecordingHost host;
  Roster roster;
};

TEST(Roster, ReportsABenchOnceWhenItComes) {
  HostedRoster hosted;
  EXPECT_THAT(hosted.take({bench_info(1), bench_info(2)}), ElementsAre("add 1", "add 2"));
  EXPECT_THAT(hosted.take({bench_info(1), bench_info(2)}), IsEmpty());
  EXPECT_EQ(hosted.roster.all().size(), 2U);
  EXPECT_FALSE(hosted.roster.find(3));
}

TEST(Roster, LeavesOutBenchesThatAreNotWantedOrHaveNoAxes) {
  HostedRoster hosted({2, 3});
  BenchInfo empty = bench_info(3);
  empty.axes.clear();
  EXPECT_THAT(hosted.take({bench_info(1), bench_info(2), empty}), ElementsAre("add 2"));
}

TEST(Roster, RenewsABenchThatContinuesAsAnotherRun) {
  HostedRoster hosted;
  (void)hosted.take({bench_info(1)});
  hosted.roster.note(change_of(ServiceNews::fell_silent), kRosterBegin);
  EXPECT_FALSE(hosted.roster.find(1)->is_alive);
  EXPECT_THAT(hosted.take({bench_info(1, 2)}), ElementsAre("renew 1"));
  EXPECT_TRUE(hosted.roster.find(1)->is_alive)
      << "the report of its silence is about the run before";
  EXPECT_EQ(hosted.roster.find(1)->info.incarnation, 2U);
}

TEST(Roster, ReplacesABenchWithOtherAxes) {
  HostedRoster hosted;
  (void)hosted.take({bench_info(1)});
  EXPECT_THAT(hosted.take({bench_info(1, 2, "y")}), ElementsAre("replace 1", "add 1"));
}

TEST(Roster, KeepsASilentBenchAsLongAsItsPatience) {
  HostedRoster hosted;
  (void)hosted.take({bench_info(1)});
  EXPECT_THAT(hosted.take({}, kRosterBegin + Roster::kPatience), IsEmpty());
  EXPECT_THAT(hosted.take({}, kRosterBegin + Roster::kPatience + 1ms), ElementsAre("remove 1"));
  EXPECT_THAT(hosted.take({bench_info(1)}, kRosterBegin + 2min), ElementsAre("add 1"));
}

TEST(Roster, CountsThePatienceFromTheNewestSample) {
  HostedRoster hosted;
  BenchInfo old = bench_info(1);
  old.sample_age = 200ms;
  (void)hosted.take({old});
  EXPECT_EQ(hosted.roster.find(1)->newest_sample, kRosterBegin - 200ms);
  hosted.roster.refresh({bench_info(1)}, kRosterBegin + 30s);
  EXPECT_THAT(hosted.take({}, kRosterBegin + 80s), IsEmpty());
  hosted.roster.note(change_of(ServiceNews::fell_silent, 70s), kRosterBegin + 80s);
  EXPECT_THAT(hosted.take({}, kRosterBegin + 80s), ElementsAre("remove 1"));
}

TEST(Roster, ForgetsABenchThatAnnouncedItsEndAtOnce) {
  HostedRoster hosted;
  (void)hosted.take({bench_info(1)});
  hosted.roster.note(change_of(ServiceNews::went_offline), kRosterBegin);
  EXPECT_THAT(hosted.take({}), ElementsAre("remove 1"));
}

TEST(Roster, KeepsABenchThatStartsAgainAfterItAnnouncedItsEnd) {
  HostedRoster hosted;
  (void)hosted.take({bench_info(1)});
  hosted.roster.note(change_of(ServiceNews::went_offline), kRosterBegin);
  EXPECT_THAT(hosted.take({bench_info(1, 2)}), ElementsAre("renew 1"));
}

TEST(Roster, RefreshesOnlyTheRunThatItKnows) {
  HostedRoster hosted;
  (void)hosted.take({bench_info(1)});
  BenchInfo later = bench_info(1);
  later.tick = 77;
  hosted.roster.refresh({later, bench_info(2)}, kRosterBegin);
  EXPECT_EQ(hosted.roster.find(1)->info.tick, 77U);
  EXPECT_EQ(hosted.roster.all().size(), 1U) << "a bench comes by take()";
  hosted.roster.refresh({bench_info(1, 2)}, kRosterBegin);
  EXPECT_EQ(hosted.roster.find(1)->info.incarnation, 1U)
      << "its readers would miss that it is renewed";
}

TEST(Roster, LeavesOutABenchAndSaysOnceWhy) {
  HostedRoster hosted;
  hosted.host.refused[2] = "no room";
  EXPECT_THAT(hosted.take({bench_info(1), bench_info(2)}),
              ElementsAre("add 1", "leave out 2: no room"));
  EXPECT_THAT(hosted.take({bench_info(1), bench_info(2)}), IsEmpty());
  EXPECT_THAT(hosted.roster.left_out(), ElementsAre(Pair(2, "no room")));
  hosted.host.refused[2] = "no name";
  EXPECT_THAT(hosted.take({bench_info(2)}), ElementsAre("leave out 2: no name"));
}

TEST(Roster, OffersABenchAgainThatIsLeftOut) {
  HostedRoster hosted;
  hosted.host.refused[2] = "no room";
  (void)hosted.take({bench_info(2)});
  hosted.host.refused.clear();
  EXPECT_THAT(hosted.take({}), IsEmpty()) << "not while it is away";
  EXPECT_THAT(hosted.roster.left_out(), IsEmpty());
  EXPECT_THAT(hosted.take({bench_info(2)}), ElementsAre("add 2"));
  EXPECT_TRUE(hosted.roster.find(2)->is_served);
}

TEST(Roster, RemovesNoBenchThatWasLeftOut) {
  HostedRoster hosted;
  hosted.host.refused[1] = "no room";
  (void)hosted.take({bench_info(1)});
  EXPECT_THAT(hosted.take({bench_info(1, 2, "y")}), ElementsAre("leave out 1: no room"))
      << "another bench";
  EXPECT_THAT(hosted.take({}, kRosterBegin + 2min), IsEmpty());
  EXPECT_FALSE(hosted.roster.find(1));
}

TEST(Roster, RemovesBeforeItAdds) {
  HostedRoster hosted;
  (void)hosted.take({bench_info(2)});
  EXPECT_THAT(hosted.take({bench_info(1), bench_info(2, 2, "y")}),
              ElementsAre("replace 2", "add 1", "add 2"));
}

}  // namespace
}  // namespace vdrive::bridge
