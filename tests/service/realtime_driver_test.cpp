// SPDX-License-Identifier: Apache-2.0
#include "clock/realtime_driver.hpp"

#include "base/event_codes.hpp"
#include "core/support/allocation_guard.hpp"
#include "service/engine_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::nanoseconds kWall = 1'700'000'000s;

/// Time that passes only during a wait, which ends as late as the test wants.
class FakeTimer final : public service::CycleTimer {
 public:
  explicit FakeTimer(std::chrono::nanoseconds begin) : now(begin) {}

  [[nodiscard]] std::chrono::nanoseconds monotonic_now() noexcept override { return now; }

  [[nodiscard]] std::chrono::nanoseconds wall_now() noexcept override {
    return kWall + now + wall_step;
  }

  void wait_until(std::chrono::nanoseconds deadline) noexcept override {
    now = std::max(now, deadline) + lateness;
  }

  std::chrono::nanoseconds now;
  std::chrono::nanoseconds lateness{0};
  std::chrono::nanoseconds wall_step{0};  ///< by which the wall clock was set forward
};

service::Configuration realtime_configuration(double rate = 1.0) {
  auto configuration = bench_configuration(2);
  configuration.clock = service::ClockMode::realtime;
  configuration.rate = rate;
  return configuration;
}

struct RealtimeBench : EngineUnderTest {
  /// @param begin monotonic time at the start
  explicit RealtimeBench(const service::Configuration& with = realtime_configuration(),
                         std::chrono::nanoseconds begin = {})
      : EngineUnderTest(with), timer(begin), driver(with, engine, inbox, counters, timer) {}

  void cycles(int count) {
    for (int cycle = 0; cycle < count; ++cycle) {
      driver.cycle();
      while (outbox.status.front() != nullptr) {
        images.push_back(outbox.status.front()->tick);
        skipped.push_back(outbox.status.front()->skipped);
        outbox.status.pop();
      }
    }
  }

  FakeTimer timer;
  service::RealtimeDriver driver;
  std::vector<std::uint64_t> images;   ///< the tick of each
  std::vector<std::uint64_t> skipped;  ///< the number of skipped ticks that each shows
};

/// @return a request to set the rate.
msg::Request rate_request(RealtimeBench& bench, double rate) {
  auto request = bench.make_request(msg::RequestKind::set_rate, kAlice);
  request.rate = rate;
  return request;
}

TEST(RealtimeDriver, RunsEachTickOnceByTheWallClock) {
  RealtimeBench bench;
  bench.cycles(1'000);
  EXPECT_EQ(bench.engine.tick(), 1'700'000'001'000U);
  EXPECT_EQ(bench.timer.now, 1s);
  ASSERT_EQ(bench.images.size(), 1'000U);
  EXPECT_EQ(bench.images.front(), 1'700'000'000'001U);
  EXPECT_EQ(bench.counters.overruns.get(), 0U);
  EXPECT_EQ(bench.counters.jumps.get(), 0U);
}

TEST(RealtimeDriver, CatchesUpAfterAShortStall) {
  RealtimeBench bench;
  bench.cycles(10);
  bench.timer.now += 50ms;
  bench.cycles(50);
  EXPECT_EQ(bench.engine.tick(), 1'700'000'000'060U);
  EXPECT_EQ(bench.timer.now, 60ms) << "as many ticks as time";
  EXPECT_EQ(bench.counters.jumps.get(), 0U);
  EXPECT_GT(bench.counters.overruns.get(), 0U);
  EXPECT_FALSE(bench.events(msg::EventKind::tick_overrun).empty());
}

// On a machine that needs 1.5 ms for a tick, each tick is late: 40,000 in a minute. The first is
// reported immediately, the others at 1, 3, 7, 15 and 31 s, at the end of spans of 1, 2, 4, 8 and
// 16 s. The next span, of 32 s, ends at 63 s.
TEST(RealtimeDriver, TellsOfAMinuteOfLateTicksInSixEvents) {
  RealtimeBench bench;
  bench.timer.lateness = 1'500us;
  while (bench.timer.now < 60s) bench.cycles(1);
  const std::uint64_t overruns = bench.counters.overruns.get();
  EXPECT_GT(overruns, 39'000U);
  std::uint64_t told = 0;
  const auto events = bench.events(msg::EventKind::tick_overrun);
  for (const auto& event : events) told += std::get<service::Overruns>(event.detail).count;
  EXPECT_EQ(events.size(), 6U);
  EXPECT_GT(told, overruns / 3) << "the rest follows at the end of its span";
}

TEST(RealtimeDriver, JumpsAfterALongStallAndHoldsTheState) {
  RealtimeBench bench;
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.cycles(10);
  bench.timer.now += 5s;
  bench.cycles(1);
  EXPECT_EQ(bench.engine.tick(), 1'700'000'005'010U);
  EXPECT_EQ(bench.counters.jumps.get(), 1U);
  const auto events = bench.events(msg::EventKind::tick_jumped);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].detail, service::EventDetail{service::Count{4'999}});
  EXPECT_EQ(bench.counters.master_losses.get(), 0U) << "no drive time passed";
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27);
}

TEST(RealtimeDriver, ReportsAStepOfTheWallClockAndCorrectsIt) {
  for (const auto offset : {10s, -3'600s}) {
    RealtimeBench bench;
    bench.cycles(10);
    bench.timer.wall_step = offset;
    bench.cycles(1'000);
    const auto events = bench.events(msg::EventKind::wall_clock);
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].code, service::WallClockCode::kSteered);
    EXPECT_NEAR(static_cast<double>(std::get<std::chrono::microseconds>(events[0].detail).count()),
                1e6 * static_cast<double>(offset.count()), 5.0);
    EXPECT_EQ(bench.counters.wall_steps.get(), 1U);
    // 1,000 ticks at 500 ppm have corrected half a millisecond.
    EXPECT_NEAR(std::abs(bench.counters.wall_offset.get()),
                std::abs(static_cast<double>(offset.count())) - 0.5e-3, 1e-5);
    EXPECT_EQ(bench.engine.tick(), 1'700'000'001'010U) << "every number once";
    EXPECT_EQ(bench.counters.jumps.get(), 0U);
  }
}

TEST(RealtimeDriver, JumpsWithTheWallClockWhereItIsConfigured) {
  auto configuration = realtime_configuration();
  configuration.clock_step = service::WallStepPolicy::jump;
  RealtimeBench bench(configuration);
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.cycles(10);
  bench.timer.wall_step = 10s;
  bench.cycles(50);
  EXPECT_EQ(bench.engine.tick(), 1'700'000'000'060U + 10'000U);
  EXPECT_EQ(bench.counters.jumps.get(), 1U);
  const auto jumps = bench.events(msg::EventKind::tick_jumped);
  ASSERT_EQ(jumps.size(), 1U);
  EXPECT_EQ(jumps[0].detail, service::EventDetail{service::Count{10'000}});
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27) << "no drive time passed";
}

// A stall of 5 s at tick 10, then a step of 10 s: each image has the number of ticks skipped so
// far.
TEST(RealtimeDriver, ShowsInEachStatusHowManyTicksTheNumberHasSkipped) {
  auto configuration = realtime_configuration();
  configuration.clock_step = service::WallStepPolicy::jump;
  RealtimeBench bench(configuration);
  bench.cycles(10);
  EXPECT_EQ(bench.skipped.back(), 0U);
  bench.timer.now += 5s;
  bench.cycles(1);
  EXPECT_EQ(bench.skipped.back(), 4'999U);
  bench.timer.wall_step = 10s;
  bench.cycles(100);
  EXPECT_NEAR(static_cast<double>(bench.skipped.back()), 14'999.0, 2.0);
  const auto [tick, skipped] = bench.counters.tick.read();
  EXPECT_EQ(tick, bench.engine.tick());
  EXPECT_EQ(skipped, bench.skipped.back());
  EXPECT_EQ(tick - 1'700'000'000'000U - skipped, bench.counters.ticks_run.get());
}

TEST(RealtimeDriver, RepeatsNoTickWhenTheWallClockGoesBack) {
  auto configuration = realtime_configuration();
  configuration.clock_step = service::WallStepPolicy::jump;
  RealtimeBench bench(configuration);
  bench.cycles(10);
  bench.timer.wall_step = -10s;
  bench.cycles(100);
  ASSERT_EQ(bench.images.size(), 110U);
  for (std::size_t i = 1; i < bench.images.size(); ++i) {
    ASSERT_EQ(bench.images[i], bench.images[i - 1] + 1);
  }
  const auto events = bench.events(msg::EventKind::wall_clock);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].code, service::WallClockCode::kSteered);
}

TEST(RealtimeDriver, HasNoOffsetToTheWallClockWhilePaused) {
  RealtimeBench bench;
  bench.timer.wall_step = 10s;
  bench.cycles(10);
  EXPECT_GT(bench.counters.wall_offset.get(), 9.0);
  bench.inbox.receive(rate_request(bench, 0.0), {});
  bench.cycles(2);
  EXPECT_EQ(bench.counters.wall_offset.get(), 0.0);
}

TEST(RealtimeDriver, MeasuresTheLatenessOfTicks) {
  RealtimeBench bench;
  bench.timer.lateness = 10us;
  bench.cycles(100);
  EXPECT_EQ(bench.counters.lateness[4].get(), 100U);  // 8 to 16 us
}

TEST(RealtimeDriver, HandlesMessagesThatArrivedBeforeTheTick) {
  RealtimeBench bench;
  bench.cycles(5);
  bench.inbox.receive(bench.make_request(msg::RequestKind::power_cycle, kAlice, {1}), {});
  bench.cycles(1);
  ASSERT_NE(bench.outbox.replies.front(), nullptr);
  EXPECT_EQ(bench.outbox.replies.front()->reply.tick, bench.engine.tick());
}

TEST(RealtimeDriver, SpreadsAFloodOverTheNextTicks) {
  RealtimeBench bench;
  for (int count = 0; count < 600; ++count) {
    bench.inbox.receive(bench.make_request(msg::RequestKind::read, kAlice), {});
  }
  bench.cycles(1);
  EXPECT_EQ(bench.inbox.size(), 600 - service::RealtimeDriver::kArrivalsPerTick);
}

// 256 replies fit and are not taken, so the other 44 requests wait instead of being dropped.
TEST(RealtimeDriver, LeavesRequestsWithoutRoomForAnAnswerInTheInbox) {
  RealtimeBench bench;
  for (int count = 0; count < 300; ++count) {
    bench.inbox.receive(bench.make_request(msg::RequestKind::read, kAlice), {});
  }
  bench.cycles(5);
  EXPECT_EQ(bench.outbox.replies.size(), service::Outbox::kReplies);
  EXPECT_EQ(bench.inbox.size(), 300 - service::Outbox::kReplies);
  while (bench.outbox.replies.front() != nullptr) bench.outbox.replies.pop();
  bench.cycles(1);
  EXPECT_EQ(bench.inbox.size(), 0U);
  EXPECT_EQ(bench.outbox.replies.size(), 300 - service::Outbox::kReplies);
  EXPECT_EQ(bench.counters.queue_overflows.get(), 0U);
}

TEST(RealtimeDriver, RunsAtTheGivenRate) {
  RealtimeBench bench(realtime_configuration(10.0));
  bench.cycles(1'000);
  EXPECT_EQ(bench.engine.tick(), 1'700'000'001'000U);
  EXPECT_NEAR(static_cast<double>(bench.timer.now.count()), 1.009e8, 1e5);
}

/// Requests the rate. @return the reason of the answer.
msg::Reason set_rate(RealtimeBench& bench, double rate) {
  return bench.reply_to(rate_request(bench, rate)).reason;
}

TEST(RealtimeDriver, PausesAndContinuesWithTheNextTick) {
  RealtimeBench bench;
  bench.cycles(10);
  EXPECT_EQ(set_rate(bench, 0.0), msg::Reason::none);
  bench.cycles(1'000);  // 1 ms each
  EXPECT_EQ(bench.engine.tick(), 1'700'000'000'010U);
  EXPECT_EQ(bench.counters.rate.get(), 0.0);
  EXPECT_EQ(set_rate(bench, 1.0), msg::Reason::none);
  bench.cycles(1 + 5);  // the rate takes effect in the first
  EXPECT_EQ(bench.engine.tick(), 1'700'000'000'015U);
  EXPECT_EQ(bench.counters.jumps.get(), 0U);
  EXPECT_EQ(bench.counters.overruns.get(), 0U);
  EXPECT_EQ(bench.events(msg::EventKind::clock_changed).size(), 2U);
}

TEST(RealtimeDriver, RunsFasterFromTheTimeOfTheRequest) {
  RealtimeBench bench;
  bench.cycles(10);
  EXPECT_EQ(set_rate(bench, 100.0), msg::Reason::none);
  const auto before = bench.timer.now;
  bench.cycles(1 + 1'000);
  EXPECT_EQ(bench.engine.tick(), 1'700'000'001'010U);
  // 1,000 ticks of 10 us; the first was due within the millisecond that had begun.
  EXPECT_LE(bench.timer.now - before, 11ms);
  EXPECT_GE(bench.timer.now - before, 10ms);
}

TEST(RealtimeDriver, FollowsTheWallClockAfterAPause) {
  RealtimeBench bench;
  bench.cycles(10);
  set_rate(bench, 0.0);
  bench.cycles(100);
  set_rate(bench, 1.0);
  const auto before = bench.timer.now;
  bench.cycles(1 + 1'000);
  EXPECT_NEAR(static_cast<double>((bench.timer.now - before).count()), 1.001e9, 1e6);
}

TEST(RealtimeDriver, RefusesARateOutOfRange) {
  RealtimeBench bench;
  for (const double rate : {-1.0, 0.09, 100.1, std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(set_rate(bench, rate), msg::Reason::out_of_range) << rate;
  }
  EXPECT_EQ(set_rate(bench, 0.1), msg::Reason::none);
  EXPECT_EQ(set_rate(bench, 100.0), msg::Reason::none);
}

TEST(RealtimeDriver, KeepsItsReferenceWhenTheRateDoesNotChange) {
  RealtimeBench bench;
  EXPECT_EQ(set_rate(bench, 1.0), msg::Reason::none);
  EXPECT_TRUE(bench.events(msg::EventKind::clock_changed).empty());
  bench.cycles(10);
  EXPECT_EQ(bench.engine.tick(), 1'700'000'000'010U);
  EXPECT_EQ(bench.timer.now, 10ms);
}

TEST(RealtimeDriver, RestartsTheWatchdogTimeWhenTheRateDrops) {
  RealtimeBench bench(realtime_configuration(100.0));
  bench.acquire(kAlice, {1});
  bench.cycles(5'000);  // 100 ms are 10,000 ticks at this rate
  set_rate(bench, 1.0);
  bench.cycles(50);
  EXPECT_EQ(bench.counters.master_losses.get(), 0U);
  bench.cycles(60);
  EXPECT_EQ(bench.counters.master_losses.get(), 1U) << "100 ticks without a word";
}

TEST(RealtimeDriver, AgreesWithAnotherBenchWhoseClockIsSynchronised) {
  RealtimeBench early;
  early.cycles(700);
  RealtimeBench late(realtime_configuration(), early.timer.now + 345us);
  early.cycles(100);
  late.cycles(100);  // begins with the next full tick, 701
  EXPECT_EQ(early.engine.tick(), late.engine.tick());
  EXPECT_NEAR(static_cast<double>((early.timer.now - late.timer.now).count()), 0.0, 1e3);
}

TEST(RealtimeDriver, AnswersRequestsWhilePaused) {
  RealtimeBench bench(realtime_configuration(0.0));
  bench.inbox.receive(bench.make_request(msg::RequestKind::read, kAlice), {});
  bench.cycles(100);
  EXPECT_EQ(bench.engine.tick(), 1'700'000'000'000U);
  EXPECT_NE(bench.outbox.replies.front(), nullptr);
}

TEST(RealtimeDriver, RepublishesTheStatusWhilePaused) {
  RealtimeBench bench(realtime_configuration(0.0));
  bench.cycles(100);  // 1 ms each
  EXPECT_EQ(bench.images.size(), 1U + 5U) << "once at the start, then every 20 ms";
}

TEST(RealtimeDriver, PublishesEveryNthTick) {
  auto configuration = realtime_configuration();
  configuration.status_every = 10;
  RealtimeBench bench(configuration);
  bench.cycles(100);
  ASSERT_EQ(bench.images.size(), 10U);
  EXPECT_EQ(bench.images.front() % 10, 0U);
}

TEST(RealtimeDriver, AllocatesNothingInATick) {
  RealtimeBench bench;
  bench.cycles(10);
  bench.images.reserve(1'000);
  bench.skipped.reserve(1'000);
  const AllocationGuard guard;
  bench.cycles(250);
  bench.timer.wall_step = 10s;
  bench.cycles(250);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace vdrive::test
