// SPDX-License-Identifier: Apache-2.0
// Clocks whose service restarts or freezes, and whose steppers are killed.
#include "client/session_options.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/client/step_clock.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <csignal>
#include <future>
#include <memory>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options;
using test::RunningService;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::array<std::uint32_t, 2> kBoth{1, 2};
constexpr std::chrono::milliseconds kSoon{500};

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
  EXPECT_THAT(lost.outcome().message(), HasSubstr("bench 2 was restarted"));
  EXPECT_EQ(sut->step(3).outcome().kind(), OutcomeKind::lost);
  EXPECT_EQ(*other.step(2, 0), 0U);
}

/// Another program that joins the clock of a bench and then does nothing.
class IdleStepper {
 public:
  explicit IdleStepper(std::uint32_t bench)
      : process_(VDRIVE_IDLE_STEPPER, {std::to_string(test::test_domain()), std::to_string(bench)}),
        session_(process_.read_line()) {}

  /// Its session as it appears in messages; empty if it could not join.
  [[nodiscard]] const std::string& session() const { return session_; }

  void kill() const { process_.send(SIGKILL); }

 private:
  test::Process process_;
  std::string session_;
};

// The killed program's participant is lost when its lease of 2 s expires; then the bench removes
// the program from the clock.
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

/// A real-time bench whose tick number jumps by more than a second.
class JumpingBench : public testing::Test {
 protected:
  /// Freezes the service until it has been silent for a second, then lets it continue.
  void let_the_tick_jump() {
    service_.freeze();
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (age_of_samples() < 1s) ASSERT_LT(std::chrono::steady_clock::now(), end);
    service_.thaw();
  }

  /// @return the snapshot that a session shows at this moment, all from the same sample.
  [[nodiscard]] AxisSnapshot now(Session& session) {
    return session.axis("1.1").value().status().value();
  }

  RunningService service_{"--axes 1"};
  Session session_{options()};

 private:
  /// @return the age of the newest sample. It is larger for a bench that is no longer present.
  std::chrono::nanoseconds age_of_samples() {
    const auto benches = session_.present_benches();
    if (!benches.empty()) silent_since_ = std::chrono::steady_clock::now();
    return std::chrono::steady_clock::now() - silent_since_;
  }

  std::chrono::steady_clock::time_point silent_since_ = std::chrono::steady_clock::now();
};

// Each call is given 2 s of drive time, and the tick number jumps over one of these seconds.
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

// A jump past the awaited tick number counts as reaching it.
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

}  // namespace
}  // namespace vdrive::client
