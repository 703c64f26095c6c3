// SPDX-License-Identifier: Apache-2.0
// The parts of a session that several threads use: wake-ups, unanswered messages, held axes.
#include "base/wakeup.hpp"
#include "exchange/bench_links.hpp"
#include "exchange/held_axes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <thread>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::Field;
using testing::IsEmpty;

constexpr BenchKey kBench{1, 10};
constexpr BenchKey kOtherBench{2, 10};
constexpr BenchKey kNextRun{1, 11};
constexpr auto kEver = Directory::Clock::time_point::max();

// ---- wake-ups --------------------------------------------------------------------------------

/// @return whether a wait for more than `changes` ends before its deadline.
bool is_woken(Wakeup& sut, std::uint64_t changes) {
  const auto deadline = Wakeup::Clock::now() + 10s;
  sut.wait_until(changes, deadline);
  return Wakeup::Clock::now() < deadline;
}

TEST(Wakeup, MissesNoChangeBetweenTheConditionAndTheWait) {
  Wakeup sut;
  const std::uint64_t changes = sut.changes();
  sut.notify();
  EXPECT_TRUE(is_woken(sut, changes));
}

// Many rounds, so that in some the change arrives during the wait.
TEST(Wakeup, WakesACallInAnotherThread) {
  constexpr int kRounds = 200;
  Wakeup sut;
  std::atomic<int> begun = 0;
  std::jthread other([&] {
    for (int round = 0; round < kRounds; ++round) {
      begun.wait(round);
      std::this_thread::yield();
      sut.notify();
    }
  });
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t changes = sut.changes();
    ++begun;
    begun.notify_one();
    EXPECT_TRUE(is_woken(sut, changes)) << "round " << round;
    if (HasFailure()) break;
  }
  begun = kRounds + 1;
  begun.notify_one();
}

TEST(Wakeup, WorksUntilSomethingHasChangedAndTellsWhetherItWorked) {
  constexpr std::uint32_t kWorked = 3;
  Wakeup sut;
  EXPECT_FALSE(sut.work(sut.changes(), kWorked));  // no work
  int left = 5;
  sut.work_with([&](std::uint32_t bench) {
    EXPECT_EQ(bench, kWorked);
    if (left == 0) return wire::LocalWork::none;
    if (--left == 2) sut.notify();
    return wire::LocalWork::done;
  });
  const std::uint64_t changes = sut.changes();
  EXPECT_TRUE(sut.work(changes, kWorked));
  EXPECT_EQ(left, 2);
  EXPECT_FALSE(sut.work(changes, kWorked)) << "it has changed";
  EXPECT_EQ(left, 2);
  EXPECT_TRUE(sut.work(sut.changes(), kWorked));
  EXPECT_EQ(left, 0);
  EXPECT_FALSE(sut.work(sut.changes(), kWorked));
}

TEST(Wakeup, ComesAgainSoonWhereAnotherThreadWorks) {
  Wakeup sut;
  sut.work_with([](std::uint32_t /*bench*/) {
    return wire::LocalWork::elsewhere;
  });
  EXPECT_FALSE(sut.work(sut.changes(), 1));
  const auto deadline = Wakeup::Clock::now() + 10s;
  sut.work_until(sut.changes(), 1, deadline);
  EXPECT_LT(Wakeup::Clock::now(), deadline) << "that thread may leave the rest to this one";
}

TEST(Wakeup, WaitsNoLongerThanItsDeadline) {
  Wakeup sut;
  const auto deadline = Wakeup::Clock::now() + 20ms;
  sut.wait_until(sut.changes(), deadline);
  EXPECT_GE(Wakeup::Clock::now(), deadline) << "it ended before its deadline, without a change";
}

TEST(Wakeup, CountsAnInterruptAsAChange) {
  Wakeup sut;
  const std::uint64_t changes = sut.changes();
  EXPECT_FALSE(sut.is_interrupted());
  sut.interrupt();
  EXPECT_TRUE(is_woken(sut, changes));
  EXPECT_TRUE(sut.is_interrupted());
}

TEST(Wakeup, IgnoresAnEarlierInterruptInTheThreadThatStops) {
  Wakeup sut;
  sut.interrupt();
  {
    const Wakeup::StopInProgress stop(sut);
    EXPECT_FALSE(sut.is_interrupted());
    std::async(std::launch::async, [&sut] {
      EXPECT_TRUE(sut.is_interrupted()) << "another call";
    }).wait();
    Wakeup other;
    other.interrupt();
    EXPECT_TRUE(other.is_interrupted()) << "another session";
    sut.interrupt();
    EXPECT_TRUE(sut.is_interrupted()) << "a later interrupt";
  }
  EXPECT_TRUE(sut.is_interrupted());
}

// ---- unanswered messages ------------------------------------------------------------------------

using Numbers = Unanswered<int, int, int>;

TEST(UnansweredMessages, KeepAnAnswerUnderItsNumber) {
  Numbers sut;
  EXPECT_EQ(sut.add(1, kBench, 100), 100);
  sut.add(2, kBench, 200);
  EXPECT_TRUE(sut.answer(2, -2));
  EXPECT_FALSE(sut.is_answered(1));
  EXPECT_TRUE(sut.is_answered(2));
  EXPECT_EQ(sut.message(1), 100);
  EXPECT_EQ(sut.take(2), -2);
  EXPECT_EQ(sut.take(1), std::nullopt);
}

TEST(UnansweredMessages, IgnoreAnAnswerThatIsNotAwaited) {
  Numbers sut;
  EXPECT_FALSE(sut.answer(1, -1));
  sut.add(1, kBench, 100);
  EXPECT_EQ(sut.take(1), std::nullopt);
  EXPECT_FALSE(sut.answer(1, -1));
}

TEST(UnansweredMessages, AreRepeatedInOrderToTheirRunUntilAnswered) {
  Numbers sut;
  sut.add(3, kBench, 300);
  sut.add(1, kBench, 100);
  sut.add(2, kBench, 200);
  sut.add(4, kNextRun, 400);
  sut.answer(2, -2);
  EXPECT_THAT(sut.to_repeat(kBench, kEver), ElementsAre(100, 300));
  sut.answer(1, -1);
  EXPECT_THAT(sut.to_repeat(kBench, kEver), ElementsAre(300));
}

TEST(UnansweredMessages, AreDueOnlyIfSentBeforeTheGivenTime) {
  Numbers sut;
  const auto before = Directory::Clock::now();
  sut.add(1, kBench, 100);
  EXPECT_FALSE(sut.has_due(kBench, before));
  EXPECT_THAT(sut.to_repeat(kBench, before), IsEmpty());
  EXPECT_TRUE(sut.has_due(kBench, kEver));
  EXPECT_FALSE(sut.has_due(kNextRun, kEver));
}

TEST(UnansweredMessages, CanBeAnsweredByAnotherThreadDuringRepetition) {
  constexpr int kCount = 1000;
  Numbers sut;
  for (int number = 0; number < kCount; ++number) sut.add(number, kBench, number);
  std::jthread other([&sut] {
    for (int number = 0; number < kCount; ++number) sut.answer(number, -number);
  });
  while (!sut.to_repeat(kBench, kEver).empty()) {
  }
  for (int number = 0; number < kCount; ++number) EXPECT_EQ(sut.take(number), -number);
}

// ---- held axes ----------------------------------------------------------------------------------

constexpr std::array<std::uint16_t, 2> kAxes{1, 2};

msg::CommandReply refusal(const BenchKey& key, std::uint64_t sequence, msg::Reason reason) {
  msg::CommandReply reply;
  reply.bench = key.number;
  reply.incarnation = key.incarnation;
  reply.sequence_number = sequence;
  reply.refusals.emplace_back().reason = reason;
  return reply;
}

TEST(HeldAxes, NumberTheFramesOfEachRunFromOne) {
  HeldAxes sut(99);
  EXPECT_EQ(sut.last_sequence(kBench), 0U);
  EXPECT_EQ(sut.next_frame(kBench).sequence_number, 1U);
  EXPECT_EQ(sut.next_frame(kBench).sequence_number, 2U);
  EXPECT_EQ(sut.next_frame(kOtherBench).sequence_number, 1U);
  EXPECT_EQ(sut.last_sequence(kBench), 2U);
  EXPECT_EQ(sut.next_frame(kNextRun).sequence_number, 1U);
}

TEST(HeldAxes, PutSessionRunAndEpochIntoAFrame) {
  HeldAxes sut(99);
  sut.note_acquired(kBench, kAxes, 5, true);
  const msg::CommandFrame frame = sut.next_frame(kBench);
  EXPECT_EQ(frame.session, 99U);
  EXPECT_EQ(frame.bench, 1U);
  EXPECT_EQ(frame.incarnation, 10U);
  EXPECT_EQ(frame.epoch, 5U);
}

TEST(HeldAxes, LoseControlOnlyByARefusedFrameOfThePresentEpoch) {
  HeldAxes sut(99);
  (void)sut.next_frame(kBench);  // 1: of the previous epoch
  sut.note_acquired(kBench, kAxes, 5, true);
  (void)sut.next_frame(kBench);  // 2
  sut.note_answer(refusal(kBench, 1, msg::Reason::stale_epoch));
  sut.note_answer(refusal(kNextRun, 2, msg::Reason::stale_epoch));
  sut.note_answer(refusal(kBench, 2, msg::Reason::too_late));
  EXPECT_TRUE(sut.holds(kBench, kAxes));
  sut.note_answer(refusal(kBench, 2, msg::Reason::stale_epoch));
  EXPECT_FALSE(sut.holds(kBench, kAxes));
  EXPECT_THAT(sut.to_keep_alive(), IsEmpty());
}

TEST(HeldAxes, NeedKeepAlivesForHeldAxesUnderAWallClock) {
  HeldAxes sut(99);
  sut.note_acquired(kBench, kAxes, 5, true);
  sut.note_acquired(kOtherBench, kAxes, 1, false);
  EXPECT_THAT(sut.to_keep_alive(), ElementsAre(kBench));
  EXPECT_EQ(sut.next_keep_alive(kBench)->sequence_number, 1U);
  EXPECT_FALSE(sut.next_keep_alive(kNextRun)) << "another run has the number";
  EXPECT_THAT(sut.drop_all(), ElementsAre(Field(&ReleasedAxes::key, kBench),
                                          Field(&ReleasedAxes::key, kOtherBench)));
  EXPECT_THAT(sut.to_keep_alive(), IsEmpty());
  EXPECT_THAT(sut.drop_all(), IsEmpty());
}

/// @return a snapshot of an axis of kBench that runs at `velocity`, or rests.
AxisSnapshot running_axis(std::uint16_t axis, std::uint64_t tick, std::int32_t velocity,
                          std::uint64_t last_sequence) {
  constexpr std::uint16_t kEnabledAndReached = 0x0637;
  AxisSnapshot snapshot;
  snapshot.id = {kBench.number, axis};
  snapshot.tick = tick;
  snapshot.owner_session = 7;
  snapshot.last_sequence = last_sequence;
  snapshot.status.ds402_statusword = kEnabledAndReached;
  snapshot.status.op_mode_actual = static_cast<std::int8_t>(OperatingMode::profile_velocity);
  snapshot.status.velocity_demand_value = velocity;
  return snapshot;
}

/// Axes 1 and 2 of kBench, held by session 7.
class RunningAxes : public testing::Test {
 protected:
  RunningAxes() { sut.note_acquired(kBench, std::array<std::uint16_t, 2>{1, 2}, 3, true); }

  void see(const AxisSnapshot& axis) { sut.note_seen(kBench, {&axis, 1}); }

  HeldAxes sut{7};
  std::array<std::uint16_t, 1> first{1};
};

TEST_F(RunningAxes, AreNotGivenBack) {
  sut.note_running(kBench, first, 5);
  see(running_axis(1, 100, 500, 5));
  const auto given = sut.drop(1);
  ASSERT_TRUE(given.has_value());
  EXPECT_THAT(given->axes, ElementsAre(2));
  EXPECT_THAT(given->kept, ElementsAre(1));
  EXPECT_THAT(sut.drop_all(), IsEmpty()) << "the watchdog needs a silent session";
}

TEST_F(RunningAxes, AreGivenBackOnceTheyWereSeenToRest) {
  sut.note_running(kBench, first, 5);
  see(running_axis(1, 100, 0, 4));
  see(running_axis(1, 101, 0, 4));
  EXPECT_TRUE(sut.is_running(kBench, 1)) << "its command was not applied yet";
  see(running_axis(1, 102, 0, 5));
  EXPECT_TRUE(sut.is_running(kBench, 1)) << "its mode may be that of before";
  see(running_axis(1, 104, 0, 5));
  EXPECT_FALSE(sut.is_running(kBench, 1));
  EXPECT_THAT(sut.drop(1)->kept, IsEmpty());
}

TEST_F(RunningAxes, AreForgottenWhenTheProgramLetsThemRunAndWhenAnotherSessionTakesThem) {
  sut.note_running(kBench, first, 5);
  sut.forget_running(kBench, first);
  EXPECT_FALSE(sut.is_running(kBench, 1));
  sut.note_running(kBench, first, 6);
  AxisSnapshot taken = running_axis(1, 100, 500, 0);
  taken.owner_session = 8;
  see(taken);
  EXPECT_FALSE(sut.is_running(kBench, 1));
}

TEST_F(RunningAxes, OfAnEarlierRunDoNotCount) {
  sut.note_running(kBench, first, 5);
  sut.note_acquired(kNextRun, first, 1, true);
  EXPECT_THAT(sut.drop(1)->kept, IsEmpty());
}

TEST(HeldAxes, AllowOneSendingThreadForEachBench) {
  HeldAxes sut(99);
  const auto sending = sut.lock_sending(1);
  std::jthread other([&sut] {
    EXPECT_FALSE(sut.try_lock_sending(1).owns_lock());
    EXPECT_TRUE(sut.try_lock_sending(2).owns_lock());
  });
  other.join();
  EXPECT_TRUE(sending.owns_lock());
}

}  // namespace
}  // namespace vdrive::client
