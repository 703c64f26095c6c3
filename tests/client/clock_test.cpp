// SPDX-License-Identifier: Apache-2.0
// Clocks of the client: steppers, pauses, freerun.
#include "support/bench_on_wire.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/client/step_clock.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <future>
#include <optional>
#include <string>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::BenchOnWire;
using test::options_on_wire;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::array<std::uint32_t, 1> kFirst{1};
constexpr std::array<std::uint32_t, 2> kBoth{1, 2};
constexpr std::chrono::milliseconds kSoon{500};

/// @return the session number as it appears in messages.
std::string hex(std::uint64_t session) {
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "0x%016llx", static_cast<unsigned long long>(session));
  return text.data();
}

TEST(StepClock, RefusesABenchThatIsNotInLockStep) {
  const BenchOnWire bench("--clock realtime");
  Session session(options_on_wire());
  const auto clock = StepClock::join(session, kFirst);
  EXPECT_EQ(clock.outcome().kind(), OutcomeKind::refused);
  EXPECT_THAT(clock.outcome().message(), HasSubstr("bench 1 runs in realtime"));
}

TEST(StepClock, StepsBenchesWithEqualPeriodsByTicks) {
  const BenchOnWire first("--clock lockstep");
  const BenchOnWire second("--clock lockstep --bench 2");
  Session session(options_on_wire());
  auto sut = StepClock::join(session, kBoth);
  ASSERT_TRUE(sut) << sut.outcome().message();
  EXPECT_THAT(*sut->step(5'000), ElementsAre(5'000, 5'000));
  EXPECT_THAT(*sut->step(1), ElementsAre(5'001, 5'001));
  EXPECT_EQ(sut->now(), 5'001ms);
}

TEST(StepClock, StepsBenchesWithDifferentPeriodsByDriveTime) {
  const BenchOnWire first("--clock lockstep");
  const BenchOnWire second("--clock lockstep --bench 2 --period 250");
  Session session(options_on_wire());
  auto sut = StepClock::join(session, kBoth);
  ASSERT_TRUE(sut) << sut.outcome().message();
  EXPECT_THAT(*sut->step_for(3ms), ElementsAre(3, 12));
  EXPECT_EQ(sut->step(1).outcome().kind(), OutcomeKind::failed);
  const auto odd = sut->step_for(500us);
  EXPECT_EQ(odd.outcome().kind(), OutcomeKind::failed);
  EXPECT_THAT(odd.outcome().message(), HasSubstr("bench 1 has ticks of 1000 us"));
  EXPECT_EQ(sut->now(), 3ms);
}

TEST(StepClock, LeavesTheClockWhenItIsDestroyed) {
  const BenchOnWire bench("--clock lockstep");
  Session stepper(options_on_wire());
  Session other(options_on_wire());
  {
    const auto sut = StepClock::join(stepper, kFirst);
    ASSERT_TRUE(sut);
    const Outcome refused = other.step(1, 1).outcome();
    EXPECT_EQ(refused.kind(), OutcomeKind::refused);
    EXPECT_THAT(refused.message(), HasSubstr("has not joined the clock"));
  }
  EXPECT_EQ(*other.step(1, 1), 1U);
}

/// Joins in another thread, because a thread that has joined a clock cannot join it again with
/// another session.
Result<StepClock> join_in_another_thread(Session& session, std::span<const std::uint32_t> benches) {
  return std::async(std::launch::async,
                    [&] {
                      return StepClock::join(session, benches);
                    })
      .get();
}

TEST(StepClock, NamesTheMissingStepperAndContinuesWithTheTicksItGranted) {
  const BenchOnWire first("--clock lockstep");
  const BenchOnWire second("--clock lockstep --bench 2");
  Session alice(options_on_wire());
  Session bob(options_on_wire());
  auto alices = StepClock::join(alice, kBoth);
  ASSERT_TRUE(alices) << alices.outcome().message();
  constexpr std::array<std::uint32_t, 1> kSecond{2};
  auto bobs = join_in_another_thread(bob, kSecond);
  ASSERT_TRUE(bobs) << bobs.outcome().message();
  const auto late = alices->step(10, kSoon);
  EXPECT_EQ(late.outcome().kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.outcome().message(), HasSubstr("bench 2 waits for stepper " + hex(bob.id())));
  EXPECT_THAT(late.outcome().message(), testing::Not(HasSubstr("bench 1")));
  EXPECT_EQ(alices->now(), 0ms);
  ASSERT_THAT(*bobs->step(10), ElementsAre(10)) << "the ticks of the other were granted";
  EXPECT_THAT(*alices->step(10), ElementsAre(10, 10)) << "the same step, not ten more";
}

TEST(StepClock, WaitsForAsManySteppersAsItIsToldTo) {
  const BenchOnWire bench("--clock lockstep");
  Session alice(options_on_wire());
  auto hers = StepClock::join(alice, kFirst, 2);
  ASSERT_TRUE(hers) << hers.outcome().message();
  const auto alone = hers->step(10, kSoon);
  EXPECT_EQ(alone.outcome().kind(), OutcomeKind::timed_out);
  EXPECT_THAT(alone.outcome().message(),
              HasSubstr("bench 1 waits for more steppers: 1 program has joined its clock"));
  auto other = std::async(std::launch::async, [] {
    Session bob(options_on_wire());
    auto his = StepClock::join(bob, kFirst, 2);
    return his ? his->step(10).outcome() : his.outcome();
  });
  EXPECT_THAT(*hers->step(10), ElementsAre(10)) << "the same call continues";
  const Outcome his = other.get();
  EXPECT_TRUE(his) << his.message();
}

TEST(StepClock, OfABenchThatAwaitsSteppersIsNotSteppedByOthers) {
  const BenchOnWire bench("--clock lockstep --steppers 2");
  Session alice(options_on_wire());
  const Outcome refused = alice.step(1, 1).outcome();
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("others have, or are awaited"));
  auto hers = StepClock::join(alice, kFirst);
  ASSERT_TRUE(hers) << hers.outcome().message();
  EXPECT_THAT(hers->step(1, kSoon).outcome().message(), HasSubstr("waits for more steppers"));
}

TEST(StepClock, RefusesToWaitForMoreThanAClockHas) {
  const BenchOnWire bench("--clock lockstep");
  Session session(options_on_wire());
  const auto clock = StepClock::join(session, kFirst, StepClock::kMostSteppers + 1);
  EXPECT_EQ(clock.outcome().kind(), OutcomeKind::refused);
  EXPECT_THAT(clock.outcome().message(), HasSubstr("a clock has at most 64 steppers"));
}

// The calls of a session that has joined a clock advance time only as far as the other stepper
// allows.
TEST(StepClock, MakesCallsOfItsSessionWaitForTheOtherSteppers) {
  const BenchOnWire bench("--clock lockstep");
  Session alice(options_on_wire());
  Session bob(options_on_wire());
  auto axis = alice.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  const auto alices = StepClock::join(alice, kFirst);
  auto bobs = join_in_another_thread(bob, kFirst);
  ASSERT_TRUE(alices && bobs);
  auto moving = std::async(std::launch::async, [&] {
    if (Outcome enabled = axis->enable(); !enabled) return enabled;
    return axis->move_to(1'000);
  });
  std::uint64_t tick = 0;
  while (moving.wait_for(0s) != std::future_status::ready) {
    const auto reached = bobs->step(5, 100ms);
    if (reached) tick = reached->front();
  }
  const Outcome moved = moving.get();
  EXPECT_TRUE(moved) << moved.message();
  EXPECT_GT(tick, 0U);
  EXPECT_EQ(*axis->read({0x6062, 0}), 1'000);
}

TEST(StepClock, ATimedOutCallNamesTheMissingStepper) {
  const BenchOnWire bench("--clock lockstep");
  Session alice(options_on_wire());
  Session bob(options_on_wire());
  auto follower = alice.follow({{1, 1}}, Pace::drive);
  const auto alices = StepClock::join(alice, kFirst);
  const auto bobs = join_in_another_thread(bob, kFirst);
  ASSERT_TRUE(follower && alices && bobs);
  const auto late = follower->next(kSoon);
  EXPECT_EQ(late.outcome().kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.outcome().message(), HasSubstr(hex(bob.id())));
}

class PausedBench : public testing::Test {
 protected:
  void SetUp() override {
    auto found = sut_.axis("1.1");
    ASSERT_TRUE(found) << found.outcome().message();
    axis_.emplace(*found);
    ASSERT_TRUE(sut_.set_rate(1, 0.0));
  }

  static void expect_paused(const Outcome& outcome) {
    EXPECT_EQ(outcome.kind(), OutcomeKind::failed);
    EXPECT_THAT(outcome.message(), HasSubstr("bench 1 is paused: rate 0"));
  }

  BenchOnWire bench_{"--clock realtime"};
  Session sut_{options_on_wire()};
  std::optional<Axis> axis_;
};

TEST_F(PausedBench, FailsCallsThatWaitForDriveTime) {
  expect_paused(axis_->enable());
  expect_paused(axis_->move_to(5));
  expect_paused(axis_->halt());
  expect_paused(axis_->quick_stop());
  expect_paused(sut_.quick_stop(1));
  expect_paused(sut_.wait(1, 1s).outcome());
  expect_paused(axis_
                    ->wait_until(
                        [](const AxisSnapshot&) {
                          return false;
                        },
                        1s)
                    .outcome());
}

TEST_F(PausedBench, AnswersRequestsAndRunsAgainAtTheNextRate) {
  EXPECT_EQ(axis_->status()->state(), PowerState::switch_on_disabled);
  EXPECT_EQ(*axis_->read({0x6041, 0}), 0x250);
  ASSERT_TRUE(sut_.set_rate(1, 2.0));
  const Outcome enabled = axis_->enable();
  EXPECT_TRUE(enabled) << enabled.message();
}

TEST(RealtimeSession, FailsAMoveWhenTheBenchIsPaused) {
  const BenchOnWire bench("--clock realtime");
  Session sut(options_on_wire());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis->enable());
  auto moving = std::async(std::launch::async, [&] {
    MoveOptions move;
    move.velocity = 100;
    return axis->move_to(1'000'000, move);
  });
  ASSERT_TRUE(axis->wait_until(
      [](const AxisSnapshot& seen) {
        return seen.status.velocity_demand_value != 0;
      },
      20s));
  ASSERT_TRUE(sut.set_rate(1, 0.0));
  EXPECT_THAT(moving.get().message(), HasSubstr("paused"));
}

TEST(RealtimeSession, RefusesARateOutOfRange) {
  const BenchOnWire bench("--clock realtime");
  Session sut(options_on_wire());
  EXPECT_EQ(sut.set_rate(1, 1'000.0).outcome().kind(), OutcomeKind::refused);
  EXPECT_EQ(sut.set_rate(1, -1.0).outcome().code(), 24U);
}

// Drive time runs a thousand times as fast as the wall clock, and the move takes less than 2 s of
// drive time. If the time-out counted from the call, it would expire before the command arrives.
TEST(FreerunSession, CountsADeadlineFromTheTickInWhichTheCommandIsInForce) {
  constexpr CallOptions kShort{.timeout = 2s};
  const BenchOnWire bench("--clock freerun");
  Session sut(options_on_wire());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  for (int round = 1; round <= 10; ++round) {
    const Outcome enabled = axis->enable(kShort);
    ASSERT_TRUE(enabled) << enabled.message();
    MoveOptions move;
    move.call = kShort;
    const Outcome moved = axis->move_by(1'000, move);
    ASSERT_TRUE(moved) << moved.message();
    const Outcome stopped = axis->quick_stop(kShort);
    ASSERT_TRUE(stopped) << stopped.message();
    const Outcome cycled = axis->power_cycle(kShort);
    ASSERT_TRUE(cycled) << cycled.message();
  }
}

TEST(FreerunSession, MovesAndWaits) {
  const BenchOnWire bench("--clock freerun");
  Session sut(options_on_wire());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  ASSERT_TRUE(axis->enable());
  const Outcome moved = axis->move_to(10'000);
  EXPECT_TRUE(moved) << moved.message();
  EXPECT_EQ(*axis->read({0x6062, 0}), 10'000);
  const auto now = sut.wait(1, 1s);
  ASSERT_TRUE(now) << now.outcome().message();
  EXPECT_GE(*sut.wait(1, 10s), *now + 10'000);
}

}  // namespace
}  // namespace vdrive::client
