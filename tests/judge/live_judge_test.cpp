// SPDX-License-Identifier: Apache-2.0
// Masters judged while their bench runs, with the same findings as from the journal of the run.
#include "live/live_judge.hpp"

#include "judge/judged_drive.hpp"
#include "replayed/bench_journal.hpp"
#include "support/random_cases.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace vdrive::judge {
namespace {

using namespace std::chrono_literals;
using client::Axis;
using client::Session;
using testing::Contains;
using testing::ElementsAreArray;
using testing::Not;

constexpr std::uint32_t kBench = 1;
constexpr ObjectAddress kLoadTorque{0x5E00, 0};

/// A bench in lock-step in this process that writes a journal, and a judge that watches it.
class JudgedBench {
 public:
  explicit JudgedBench(std::size_t axes = 1) {
    bench::BenchOptions options;
    options.axes = axes;
    options.clock = ClockMode::lockstep;
    options.journal = journal_;
    bench_.emplace(options);
    client::SessionOptions on_bus;
    on_bus.bus = bench_->bus();
    master_.emplace(on_bus);
    watcher_.emplace(on_bus);
    watch_again();
  }

  Session& master() { return *master_; }

  Axis axis() { return master_->axis("1.1").value(); }

  /// Steps one tick at a time: of a step of several ticks the bench publishes only the last.
  void step(std::uint64_t ticks = 1) {
    for (std::uint64_t i = 0; i < ticks; ++i) ASSERT_TRUE(master_->step(kBench, 1));
    poll();
  }

  /// Starts another judge.
  void watch_again() {
    auto judge = LiveJudge::create(*watcher_, kBench, watcher_->axes(kBench).value());
    ASSERT_TRUE(judge);
    judge_.emplace(std::move(*judge));
  }

  void poll() {
    const client::Outcome outcome = judge_->poll(0ms);
    ASSERT_TRUE(outcome) << outcome.message();
  }

  [[nodiscard]] std::vector<std::string> live() {
    step();
    return broken_rules(judge_->verdict());
  }

  /// Ends the bench and judges its journal.
  [[nodiscard]] std::vector<std::string> by_journal() {
    judge_.reset();
    watcher_.reset();
    master_.reset();
    bench_.reset();
    std::ifstream file(journal_, std::ios::binary);
    return broken_rules(judge_journal(file).verdict);
  }

 private:
  test::TemporaryDirectory directory_;
  std::filesystem::path journal_ = directory_.path() / "bench.journal";
  std::optional<bench::Bench> bench_;
  std::optional<Session> master_;
  std::optional<Session> watcher_;
  std::optional<LiveJudge> judge_;
};

void write(Axis& axis, ObjectAddress object, std::int64_t value) {
  ASSERT_TRUE(axis.write(object, value));
}

/// The client library sends all words up to Operation enabled before it looks at the state: a drive
/// of vdrive takes each word when it is written, and for a drive that does not, the client waits.
const std::vector<std::string> kOfTheClient{"state-2"};

/// @return `rules` without the one that only the end of a run can break: the axis is left enabled.
std::vector<std::string> without_end(std::vector<std::string> rules) {
  std::erase(rules, "supervision-7");
  return rules;
}

TEST(ABenchThatRuns, GivesNoFindingOfTheClientLibraryButOne) {
  JudgedBench bench;
  Axis axis = bench.axis();
  ASSERT_TRUE(axis.enable());
  bench.poll();
  ASSERT_TRUE(axis.move_to(2'000));
  bench.poll();
  ASSERT_TRUE(axis.move_to(-500));
  bench.poll();
  ASSERT_TRUE(axis.disable());
  EXPECT_THAT(bench.live(), ElementsAreArray(kOfTheClient));
  EXPECT_THAT(bench.by_journal(), ElementsAreArray(kOfTheClient));
}

void set_point(JudgedBench& bench, Axis& axis, std::int64_t target) {
  write(axis, objects::kTarget, target);
  write(axis, objects::kControlword, 0x1F);
  bench.step(3);
}

TEST(ABenchThatRuns, TellsThatBit4StayedUpWhileItRuns) {
  JudgedBench bench;
  Axis axis = bench.axis();
  write(axis, objects::kMode, 1);
  ASSERT_TRUE(axis.enable());
  set_point(bench, axis, 1'000);
  EXPECT_THAT(bench.live(), Not(Contains("handshake-2")));
  set_point(bench, axis, 2'000);
  EXPECT_THAT(bench.live(), Contains("handshake-2"));
}

// The axis is already enabled when the judge starts: the word 001Fh is an edge after 000Fh.
TEST(ABenchThatRuns, IsKnownWithTheWordThatStoodBefore) {
  JudgedBench bench;
  Axis axis = bench.axis();
  write(axis, objects::kMode, 1);
  ASSERT_TRUE(axis.enable());
  bench.watch_again();
  set_point(bench, axis, 1'000);
  set_point(bench, axis, 2'000);
  EXPECT_THAT(bench.live(), Contains("handshake-2"));
}

// After a restore a tick that was already published is published again.
TEST(ABenchThatRuns, TakesARestoreForAGap) {
  JudgedBench bench;
  Axis axis = bench.axis();
  const auto snapshot = bench.master().take_snapshot(kBench);
  ASSERT_TRUE(snapshot);
  write(axis, objects::kMode, 1);
  ASSERT_TRUE(axis.enable());
  bench.step(2);
  write(axis, objects::kTarget, 500);
  write(axis, objects::kControlword, 0x1F);
  ASSERT_TRUE(bench.master().restore_snapshot(kBench, *snapshot));
  bench.step(3);
  EXPECT_THAT(bench.live(), ElementsAreArray(kOfTheClient));
}

// Of a step of several ticks the bench publishes only the last.
TEST(ABenchThatRuns, KnowsWhichOfTheWordsBetweenTwoStatusesWasIgnored) {
  JudgedBench bench;
  Axis axis = bench.axis();
  ASSERT_TRUE(axis.enable());  // in mode 0, where a set-point is ignored
  bench.step(2);
  write(axis, objects::kControlword, 0x1F);
  write(axis, objects::kControlword, 0x0F);
  bench.step(1);
  EXPECT_THAT(bench.live(), Contains("handshake-4"));
}

TEST(ABenchThatRuns, KnowsWhichSetPointWasIgnored) {
  JudgedBench bench;
  Axis axis = bench.axis();
  write(axis, objects::kMode, 1);
  ASSERT_TRUE(axis.enable());
  for (int set_point = 1; set_point <= 3; ++set_point) {
    EXPECT_THAT(bench.live(), Not(Contains("handshake-4"))) << set_point;
    write(axis, objects::kTarget, 100'000 * set_point);
    write(axis, objects::kControlword, 0x1F);
    bench.step(3);
    write(axis, objects::kControlword, 0x0F);
    bench.step(3);
  }
  EXPECT_THAT(bench.live(), Contains("handshake-4"))
      << "the buffer holds one beside the present one";
}

TEST(ABenchThatRuns, TakesADisturbanceForNoMaster) {
  JudgedBench bench;
  Axis axis = bench.axis();
  ASSERT_TRUE(axis.enable());
  write(axis, kLoadTorque, 10);
  bench.step(5);
  write(axis, kLoadTorque, 0);
  ASSERT_TRUE(axis.disable());
  EXPECT_THAT(bench.live(), ElementsAreArray(kOfTheClient));
}

TEST(ABenchThatRuns, ForgetsWhatAPowerCycleEnds) {
  JudgedBench bench;
  Axis axis = bench.axis();
  ASSERT_TRUE(axis.enable());
  bench.poll();
  ASSERT_TRUE(axis.power_cycle());
  bench.step(3);
  ASSERT_TRUE(axis.enable());
  ASSERT_TRUE(axis.move_to(100));
  ASSERT_TRUE(axis.disable());
  EXPECT_THAT(bench.live(), ElementsAreArray(kOfTheClient));
}

/// Words and targets in any order: mistakes of many kinds.
void act(Axis& axis, test::Random& random) {
  constexpr std::array<std::uint16_t, 9> kWords{0x06, 0x07, 0x0F, 0x1F, 0x3F,
                                                0x5F, 0x02, 0x80, 0x00};
  switch (random.below(6)) {
    case 0:
      write(axis, objects::kTarget, static_cast<std::int64_t>(random.below(20'000)) - 10'000);
      break;
    case 1:
      write(axis, objects::kMode, random.one_in(3) ? 3 : 1);
      break;
    case 2:
      write(axis, {0x5E02, 0}, random.one_in(2) ? 1 : 0);
      break;
    default:
      write(axis, objects::kControlword, kWords[random.below(kWords.size())]);
      break;
  }
}

TEST(ABenchThatRuns, GivesTheFindingsOfTheJournalOfTheSameRun) {
  std::size_t found = 0;
  for (std::uint64_t seed = 1; seed <= test::case_count(20, 300); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    JudgedBench bench;
    Axis axis = bench.axis();
    for (int action = 0; action < 150; ++action) {
      act(axis, random);
      if (!random.one_in(4)) bench.step(random.one_in(20) ? 300 : random.below(8));
    }
    const auto live = bench.live();
    EXPECT_THAT(without_end(bench.by_journal()), ElementsAreArray(live));
    found += live.size();
  }
  EXPECT_GT(found, 3 * test::case_count(20, 300));
}

}  // namespace
}  // namespace vdrive::judge
