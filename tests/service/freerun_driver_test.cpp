// SPDX-License-Identifier: Apache-2.0
#include "clock/freerun_driver.hpp"

#include "core/support/allocation_guard.hpp"
#include "service/engine_under_test.hpp"

#include <gtest/gtest.h>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;

/// A machine whose tick duration the test sets.
class TickingTimer final : public service::CycleTimer {
 public:
  [[nodiscard]] std::chrono::nanoseconds monotonic_now() noexcept override {
    return now += tick_time;
  }

  [[nodiscard]] std::chrono::nanoseconds wall_now() noexcept override { return now; }

  void wait_until(std::chrono::nanoseconds /*deadline*/) noexcept override {
    ADD_FAILURE() << "a free-running clock waits for nothing";
  }

  std::chrono::nanoseconds now{1s};
  std::chrono::nanoseconds tick_time{5us};
};

service::Configuration freerun_configuration() {
  auto configuration = bench_configuration(2);
  configuration.clock = service::ClockMode::freerun;
  return configuration;
}

struct FreerunBench : EngineUnderTest {
  explicit FreerunBench(const service::Configuration& with = freerun_configuration())
      : EngineUnderTest(with), driver(engine, inbox, outbox, timer) {}

  void cycles(int count) {
    for (int cycle = 0; cycle < count; ++cycle) driver.cycle();
  }

  TickingTimer timer;
  service::FreerunDriver driver;
};

TEST(FreerunDriver, RunsOneTickInEachCycleFromTickZero) {
  FreerunBench bench;
  bench.cycles(1'000);
  EXPECT_EQ(bench.engine.tick(), 1'000U);
}

TEST(FreerunDriver, AnswersRequestsBetweenTwoTicks) {
  FreerunBench bench;
  bench.cycles(5);
  bench.inbox.receive(bench.make_request(msg::RequestKind::power_cycle, kAlice, {1}), {});
  bench.cycles(1);
  ASSERT_NE(bench.outbox.replies.front(), nullptr);
  EXPECT_EQ(bench.outbox.replies.front()->reply.tick, 6U);
}

// 10,000 ticks of 5 us take 50 ms: one image at the start and one every millisecond.
TEST(FreerunDriver, PublishesTheStatusOnceAMillisecondOfWallTime) {
  FreerunBench bench;
  int images = 0;
  for (int tick = 0; tick < 10'000; ++tick) {
    bench.cycles(1);
    while (bench.outbox.status.front() != nullptr) {
      ++images;
      bench.outbox.status.pop();
    }
  }
  EXPECT_NEAR(images, 50, 1);
}

TEST(FreerunDriver, SkipsAnImageWhileThePreviousOneWaits) {
  FreerunBench bench;
  bench.cycles(100'000);
  EXPECT_EQ(bench.outbox.status.size(), 1U);
  EXPECT_EQ(bench.counters.queue_overflows.get(), 0U);
}

TEST(FreerunDriver, LeavesRequestsWithoutRoomForAnAnswerToTheNextTicks) {
  FreerunBench bench;
  const std::size_t room = bench.outbox.replies.capacity();
  for (std::size_t count = 0; count < room + 50; ++count) {
    bench.inbox.receive(bench.make_request(msg::RequestKind::read, kAlice), {});
  }
  bench.cycles(3);
  EXPECT_EQ(bench.inbox.size(), 50U);
  EXPECT_EQ(bench.counters.queue_overflows.get(), 0U);
  while (bench.outbox.replies.front() != nullptr) bench.outbox.replies.pop();
  bench.cycles(1);
  EXPECT_EQ(bench.inbox.size(), 0U);
}

TEST(FreerunDriver, HasNoWatchdogByDefault) {
  FreerunBench without;
  without.acquire(kAlice, {1});
  without.cycles(100'000);
  EXPECT_EQ(without.counters.master_losses.get(), 0U);
  auto configuration = freerun_configuration();
  configuration.watchdog_is_chosen = true;
  FreerunBench with(configuration);
  with.acquire(kAlice, {1});
  with.cycles(102);  // each 1 ms long; the limit is 100
  EXPECT_EQ(with.counters.master_losses.get(), 1U);
}

TEST(FreerunDriver, RefusesStepsAndRates) {
  FreerunBench bench;
  for (const auto kind : {msg::RequestKind::step, msg::RequestKind::set_rate,
                          msg::RequestKind::join_clock, msg::RequestKind::leave_clock}) {
    EXPECT_EQ(bench.reply_to(bench.make_request(kind, kAlice)).reason,
              msg::Reason::wrong_clock_mode)
        << wire::number(kind);
  }
}

TEST(FreerunDriver, AllocatesNothingInATick) {
  FreerunBench bench;
  bench.cycles(10);
  const AllocationGuard guard;
  bench.cycles(1'000);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace vdrive::test
