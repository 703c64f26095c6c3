// SPDX-License-Identifier: Apache-2.0
// Clocks of the client against the real service: steppers, restarts, pauses, freerun.
#include "client/session_options.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/client/step_clock.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options;
using test::RunningService;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::array<std::uint32_t, 1> kFirst{1};
constexpr std::array<std::uint32_t, 2> kBoth{1, 2};
constexpr std::chrono::milliseconds kSoon{500};

/// @return the session's number as messages write it.
std::string hex(std::uint64_t session) {
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "0x%016llx", static_cast<unsigned long long>(session));
  return text.data();
}

TEST(StepClock, RefusesABenchThatIsNotInLockStep) {
  const RunningService service("--clock realtime");
  Session session(options());
  const auto clock = StepClock::join(session, kFirst);
  EXPECT_EQ(clock.outcome().kind(), OutcomeKind::refused);
  EXPECT_THAT(clock.outcome().message(), HasSubstr("bench 1 runs in realtime"));
}

TEST(StepClock, StepsBenchesWithEqualPeriodsByTicks) {
  const RunningService first("--clock lockstep");
  const RunningService second("--clock lockstep --bench 2");
  Session session(options());
  auto sut = StepClock::join(session, kBoth);
  ASSERT_TRUE(sut) << sut.outcome().message();
  EXPECT_THAT(*sut->step(5'000), ElementsAre(5'000, 5'000));
  EXPECT_THAT(*sut->step(1), ElementsAre(5'001, 5'001));
  EXPECT_EQ(sut->now(), 5'001ms);
}

TEST(StepClock, StepsBenchesWithDifferentPeriodsByDriveTime) {
  const RunningService first("--clock lockstep");
  const RunningService second("--clock lockstep --bench 2 --period 250");
  Session session(options());
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
  const RunningService service("--clock lockstep");
  Session stepper(options());
  Session other(options());
  {
    const auto sut = StepClock::join(stepper, kFirst);
    ASSERT_TRUE(sut);
    const Outcome refused = other.step(1, 1).outcome();
    EXPECT_EQ(refused.kind(), OutcomeKind::refused);
    EXPECT_THAT(refused.message(), HasSubstr("others have joined the clock"));
  }
  EXPECT_EQ(*other.step(1, 1), 1U);
}

TEST(StepClock, NamesTheMissingStepperAndContinuesWithTheTicksItGranted) {
  const RunningService first("--clock lockstep");
  const RunningService second("--clock lockstep --bench 2");
  Session alice(options());
  Session bob(options());
  auto alices = StepClock::join(alice, kBoth);
  ASSERT_TRUE(alices) << alices.outcome().message();
  constexpr std::array<std::uint32_t, 1> kSecond{2};
  auto bobs = StepClock::join(bob, kSecond);
  ASSERT_TRUE(bobs) << bobs.outcome().message();
  const auto late = alices->step(10, kSoon);
  EXPECT_EQ(late.outcome().kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.outcome().message(), HasSubstr("bench 2 waits for stepper " + hex(bob.id())));
  EXPECT_THAT(late.outcome().message(), testing::Not(HasSubstr("bench 1")));
  EXPECT_EQ(alices->now(), 0ms);
  ASSERT_THAT(*bobs->step(10), ElementsAre(10)) << "the ticks of the other were granted";
  EXPECT_THAT(*alices->step(10), ElementsAre(10, 10)) << "the same step, not ten more";
}

// The calls of a session that has joined advance time as far as the other stepper allows.
TEST(StepClock, MakesCallsOfItsSessionWaitForTheOtherSteppers) {
  const RunningService service("--clock lockstep");
  Session alice(options());
  Session bob(options());
  auto axis = alice.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  const auto alices = StepClock::join(alice, kFirst);
  auto bobs = StepClock::join(bob, kFirst);
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
  const RunningService service("--clock lockstep");
  Session alice(options());
  Session bob(options());
  auto follower = alice.follow({{1, 1}}, Pace::drive);
  const auto alices = StepClock::join(alice, kFirst);
  const auto bobs = StepClock::join(bob, kFirst);
  ASSERT_TRUE(follower && alices && bobs);
  const auto late = follower->next(kSoon);
  EXPECT_EQ(late.outcome().kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.outcome().message(), HasSubstr(hex(bob.id())));
}

TEST(StepClock, DetectsARestartAndDoesNotStepTheNewService) {
  const RunningService first("--clock lockstep");
  auto second = std::make_unique<RunningService>("--clock lockstep --bench 2");
  Session session(options());
  auto sut = StepClock::join(session, kBoth);
  ASSERT_TRUE(sut) << sut.outcome().message();
  ASSERT_TRUE(sut->step(3));
  second->kill();
  second = std::make_unique<RunningService>("--clock lockstep --bench 2");
  Session other(options());
  ASSERT_TRUE(other.find_bench(2));
  const auto lost = sut->step(3);
  EXPECT_EQ(lost.outcome().kind(), OutcomeKind::lost);
  EXPECT_THAT(lost.outcome().message(), HasSubstr("bench 2 restarted"));
  EXPECT_EQ(sut->step(3).outcome().kind(), OutcomeKind::lost);
  EXPECT_EQ(*other.step(2, 0), 0U);
}

/// Another program that joins the clock of a bench, and then does nothing.
class IdleStepper {
 public:
  explicit IdleStepper(std::uint32_t bench)
      : process_(VDRIVE_IDLE_STEPPER, {std::to_string(test::test_domain()), std::to_string(bench)}),
        session_(process_.read_line()) {}

  /// Its session as messages write it; empty when it could not join.
  [[nodiscard]] const std::string& session() const { return session_; }

  void kill() const { process_.send(SIGKILL); }

 private:
  test::Process process_;
  std::string session_;
};

// Its participant is lost after its lease of 2 s, which removes it from the clock.
TEST(StepClock, NamesAKilledProgramAndContinuesAfterItsRemovalFromTheClock) {
  const RunningService first("--clock lockstep");
  const RunningService second("--clock lockstep --bench 2");
  Session session(options());
  auto sut = StepClock::join(session, kBoth);
  ASSERT_TRUE(sut) << sut.outcome().message();
  const IdleStepper other(2);
  ASSERT_THAT(other.session(), HasSubstr("0x"));
  other.kill();
  const auto late = sut->step(10, kSoon);
  EXPECT_EQ(late.outcome().kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.outcome().message(), HasSubstr("bench 2 waits for stepper " + other.session()));
  const auto reached = sut->step(10, 20s);
  ASSERT_TRUE(reached) << reached.outcome().message();
  EXPECT_THAT(*reached, ElementsAre(10, 10));
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

  RunningService service_{"--clock realtime"};
  Session sut_{options()};
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
  const RunningService service("--clock realtime");
  Session sut(options());
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
  const RunningService service("--clock realtime");
  Session sut(options());
  EXPECT_EQ(sut.set_rate(1, 1'000.0).outcome().kind(), OutcomeKind::refused);
  EXPECT_EQ(sut.set_rate(1, -1.0).outcome().code(), 24U);
}

// Drive time runs a thousand times as fast as the wall clock: the deadline allows for that.
/// A bench in real time whose tick number jumps over more than a second.
class JumpingBench : public testing::Test {
 protected:
  /// Freezes the service until it was silent for a second, then lets it continue.
  void let_the_tick_jump() {
    service_.freeze();
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (age_of_samples() < 1s) ASSERT_LT(std::chrono::steady_clock::now(), end);
    service_.thaw();
  }

  /// @return the numbers that a session shows at once, from the same sample.
  [[nodiscard]] AxisSnapshot now(Session& session) {
    return session.axis("1.1").value().status().value();
  }

  RunningService service_{"--axes 1"};
  Session session_{options()};

 private:
  /// A bench that is not present any more is older than that.
  std::chrono::nanoseconds age_of_samples() {
    const auto benches = session_.present_benches();
    if (!benches.empty()) silent_since_ = std::chrono::steady_clock::now();
    return std::chrono::steady_clock::now() - silent_since_;
  }

  std::chrono::steady_clock::time_point silent_since_ = std::chrono::steady_clock::now();
};

// Each call is given 2 s of drive time, and the number jumps over one of them.
TEST_F(JumpingBench, UsesUpNoTimeOutOfACallThatWaits) {
  auto follower = session_.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower);
  const auto first = follower->next(20s);
  ASSERT_TRUE(first);
  Axis axis = session_.axis("1.1").value();
  std::promise<std::uint64_t> has_begun;
  std::uint64_t begin = 0;
  AxisSnapshot last;
  auto ended = std::async(std::launch::async, [&] {
    return axis.wait_until(
        [&](const AxisSnapshot& seen) {
          if (std::exchange(begin, begin == 0 ? seen.tick : begin) == 0)
            has_begun.set_value(seen.tick);
          last = seen;
          return false;
        },
        2s);
  });
  has_begun.get_future().wait();
  let_the_tick_jump();
  EXPECT_EQ(ended.get().outcome().kind(), OutcomeKind::timed_out);
  EXPECT_GE(last.skipped, 500U);
  EXPECT_GE(last.tick - begin, 2'000U + last.skipped - 10U);
  EXPECT_GE(last.driven_tick() - begin, 1'990U);
  std::uint64_t skipped = 0;
  while (const auto sample = follower->next(0ms)) skipped += sample->skipped;
  EXPECT_EQ(skipped, last.skipped) << "a follower counts the same";
}

TEST_F(JumpingBench, MakesAWaitAsLongAsItsDriveTime) {
  const std::uint64_t begin = now(session_).tick;
  auto follower = session_.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower && follower->next(20s));
  auto reached = std::async(std::launch::async, [&] {
    return session_.wait(1, 2s);
  });
  let_the_tick_jump();
  const auto tick = reached.get();
  ASSERT_TRUE(tick) << tick.outcome().message();
  std::uint64_t skipped = 0;
  while (const auto sample = follower->next(0ms)) skipped += sample->skipped;
  EXPECT_GE(skipped, 500U);
  EXPECT_GE(*tick, begin + 2'000U + skipped - 50U);
}

// A tick number that is awaited is reached by a jump over it.
TEST_F(JumpingBench, ReachesATickNumberThatItJumpsOver) {
  const std::uint64_t aim = now(session_).tick + 1'000;
  auto reached = std::async(std::launch::async, [&] {
    return session_.wait_for_tick(1, aim);
  });
  let_the_tick_jump();
  const auto tick = reached.get();
  ASSERT_TRUE(tick) << tick.outcome().message();
  EXPECT_GE(*tick, aim);
}

TEST(FreerunSession, MovesAndWaits) {
  const RunningService service("--clock freerun");
  Session sut(options());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  const CallOptions patient{.timeout = 24h};
  ASSERT_TRUE(axis->enable(patient));
  MoveOptions move;
  move.call = patient;
  const Outcome moved = axis->move_to(10'000, move);
  EXPECT_TRUE(moved) << moved.message();
  EXPECT_EQ(*axis->read({0x6062, 0}), 10'000);
  const auto now = sut.wait(1, 1s);
  ASSERT_TRUE(now) << now.outcome().message();
  EXPECT_GE(*sut.wait(1, 10s), *now + 10'000);
}

}  // namespace
}  // namespace vdrive::client
