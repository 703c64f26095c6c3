// SPDX-License-Identifier: Apache-2.0
// A link to a bench in this process.
#include "bench_link.hpp"

#include "support/deadline.hpp"
#include "vdrive/bench/bench.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::bridge {
namespace {

using testing::ElementsAre;

/// A bench in real time, a link to it, and the notifications of the link.
class LinkedBench final : public BenchAdapter {
 public:
  explicit LinkedBench(bool is_automatic = false)
      : bench_(std::in_place, options_),
        session_(session_options(*bench_)),
        link_(*this, session_, reports_, session_.find_bench(1).value(),
              {.label = "bench 1",
               .remedies = {.loss = "want it again", .faults = "reset them"},
               .is_automatic = is_automatic}) {
    options_.bus = bench_->bus();
  }

  [[nodiscard]] BenchLink& link() noexcept { return link_; }

  [[nodiscard]] client::Session& session() noexcept { return session_; }

  [[nodiscard]] client::Session other_session() const { return bench_->session(); }

  void end_bench() { bench_.reset(); }

  void begin_bench() { bench_.emplace(options_); }

  /// Waits until the latest state fits. There is no state while the bench is lost.
  bool wait_for_state(std::string_view what, const std::function<bool(const State&)>& fits) {
    return wait_for(what, [&] {
      return fits(newest_);
    });
  }

  /// Waits until this session owns all axes.
  bool wait_for_owner(std::uint64_t session) {
    return wait_for_state("an owner", [session](const State& state) {
      return state && owns_all(state->axes, session);
    });
  }

  bool wait_for(std::string_view what, const std::function<bool()>& condition) {
    constexpr std::chrono::seconds kPatience{60};
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, kPatience, condition)) return true;
    test::report_missed_deadline(what, kPatience);
    return false;
  }

  /// Changes data that wait_for() checks.
  void note(const std::string& word) {
    const std::scoped_lock lock(mutex_);
    notes_.push_back(word);
    changed_.notify_all();
  }

  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

 private:
  static client::SessionOptions session_options(const bench::Bench& bench) {
    client::SessionOptions options;
    options.bus = bench.bus();
    return options;
  }

  void on_open(const client::BenchInfo& info, const std::vector<client::Axis>& axes) override {
    note("open " + std::to_string(info.number) + " with " + std::to_string(axes.size()));
  }

  void on_state(const State& state) override {
    const std::scoped_lock lock(mutex_);
    newest_ = state;
    changed_.notify_all();
  }

  void on_lost() override {
    note("lost");
    on_state(nullptr);
  }

  bench::BenchOptions options_{.axes = 2, .clock = ClockMode::realtime};
  std::optional<bench::Bench> bench_;
  client::Session session_;
  Reports reports_{"test", {}};
  std::mutex mutex_;  ///< guards the members below
  std::condition_variable changed_;
  State newest_;
  std::vector<std::string> notes_;
  BenchLink link_;  ///< last, because its threads use the other members
};

TEST(BenchLink, ShowsStateAfterState) {
  LinkedBench bench;
  std::uint64_t first = 0;
  ASSERT_TRUE(bench.wait_for_state("a state", [&first](const auto& state) {
    if (state) first = state->tick;
    return state != nullptr;
  }));
  EXPECT_TRUE(bench.wait_for_state("a later state", [first](const auto& state) {
    return state && state->tick > first + 10 && state->axes.size() == 2;
  }));
  EXPECT_THAT(bench.notes(), ElementsAre("open 1 with 2"));
}

TEST(BenchLink, TellsThatItsBenchIsLostAndThereAgain) {
  LinkedBench bench;
  EXPECT_TRUE(bench.wait_for_owner(0));
  bench.end_bench();
  EXPECT_TRUE(bench.wait_for_state("the loss", [](const auto& state) {
    return state == nullptr;
  }));
  bench.begin_bench();
  EXPECT_TRUE(bench.wait_for_owner(0));
  EXPECT_THAT(bench.notes(), ElementsAre("open 1 with 2", "lost", "open 1 with 2"));
}

TEST(BenchLink, LeavesControlUntilItIsWanted) {
  LinkedBench bench;
  EXPECT_TRUE(bench.wait_for_owner(0));
  bench.link().want_control(true);
  EXPECT_TRUE(bench.wait_for_owner(bench.session().id()));
}

TEST(BenchLink, TakesControlBackByItselfWhereNobodyCanAskForIt) {
  LinkedBench bench(true);
  ASSERT_TRUE(bench.wait_for_owner(bench.session().id()));
  client::Session other = bench.other_session();
  std::vector<client::Axis> axes = other.axes(1).value();
  for (client::Axis& axis : axes) ASSERT_TRUE(axis.take_over());
  ASSERT_TRUE(bench.wait_for_owner(other.id()));
  ASSERT_TRUE(other.release());
  EXPECT_TRUE(bench.wait_for_owner(bench.session().id()));
}

TEST(BenchLink, DoesTheJobsOfAnAxisInTheirOrder) {
  LinkedBench bench;
  ASSERT_TRUE(bench.wait_for_owner(0));
  std::vector<std::uint16_t> axes;
  int done = 0;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(bench.link().post(1, AxisJobs::kAccess, [&, i](const client::Axis& axis) {
      axes.push_back(axis.id().axis);
      if (done == i) ++done;
      bench.note("job");
    }));
  }
  ASSERT_TRUE(bench.wait_for("the jobs", [&] {
    return bench.notes().size() == 6;  // after the first one, which reports the opening
  }));
  EXPECT_EQ(done, 5);
  EXPECT_THAT(axes, ElementsAre(2, 2, 2, 2, 2));
}

TEST(BenchLink, DropsTheOldestOfMoreFramesThanItHasRoomFor) {
  LinkedBench bench(true);
  ASSERT_TRUE(bench.wait_for_owner(bench.session().id()));
  std::vector<client::SetPointFrame> frames(BenchLink::kMostWaitingFrames + 6);
  for (client::SetPointFrame& frame : frames) frame.axes.push_back({.axis = 1, .velocity = 0});
  bench.link().send(std::move(frames));
  EXPECT_EQ(bench.link().dropped_frames(), 6U);
}

/// An adapter that ignores everything.
struct SilentAdapter final : BenchAdapter {
  void on_state(const State& /*state*/) override {}

  void on_lost() override {}
};

TEST(BenchLink, RefusesJobsForABenchThatWasNeverThere) {
  const bench::Bench other({.axes = 1});
  client::SessionOptions options;
  options.bus = other.bus();
  client::Session session(options);
  Reports reports{"test", {}};
  SilentAdapter adapter;
  client::BenchInfo info;
  info.number = 7;
  info.axes.emplace_back().id = {7, 1};
  BenchLink link(adapter, session, reports, info, {.label = "bench 7"});
  EXPECT_FALSE(link.post(0, AxisJobs::kAccess, [](client::Axis&) {}));
  session.interrupt();  // otherwise its destructor waits for the search
}

}  // namespace
}  // namespace vdrive::bridge
