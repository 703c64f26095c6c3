// SPDX-License-Identifier: Apache-2.0
#include "clock/shutdown.hpp"

#include "service/engine_under_test.hpp"

#include <gtest/gtest.h>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using service::ClockMode;
using service::Shutdown;

class HandTimer final : public service::CycleTimer {
 public:
  [[nodiscard]] std::chrono::nanoseconds monotonic_now() noexcept override { return now; }

  [[nodiscard]] std::chrono::nanoseconds wall_now() noexcept override { return now; }

  void wait_until(std::chrono::nanoseconds /*deadline*/) noexcept override {}

  std::chrono::nanoseconds now{10s};
};

service::Configuration with_clock(ClockMode clock, double rate = 1.0) {
  auto configuration = bench_configuration(2);
  configuration.clock = clock;
  configuration.rate = rate;
  configuration.watchdog.reset();
  return configuration;
}

struct ClosingBench : EngineUnderTest {
  explicit ClosingBench(const service::Configuration& with = with_clock(ClockMode::realtime))
      : EngineUnderTest(with), shutdown(engine, timer) {}

  /// Moves at 1000 UU/s with `deceleration` in 6084h and 6085h.
  void move(std::int64_t deceleration) {
    write(kAlice, 1, 0x6081, 1'000);
    write(kAlice, 1, 0x6084, deceleration);
    write(kAlice, 1, 0x6085, deceleration);
    write(kAlice, 1, 0x6060, 1);
    write(kAlice, 1, 0x607A, 1'000'000);
    write(kAlice, 1, 0x6040, 0x0F);
    steps(2);
    write(kAlice, 1, 0x6040, 0x1F);
    steps(50);
  }

  void pass(int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      shutdown.advance();
      engine.step();
      timer.now += 1ms;
    }
  }

  HandTimer timer;
  Shutdown shutdown;
};

TEST(Shutdown, DoesNothingUntilItBegins) {
  ClosingBench bench;
  bench.move(1'000'000);
  bench.pass(10);
  EXPECT_FALSE(bench.shutdown.is_done());
  EXPECT_EQ(bench.value(1, 0x606B), 1'000);
}

TEST(Shutdown, EndsWhenTheAxesAreDisabled) {
  ClosingBench bench;
  bench.move(100'000);  // 10 ms
  bench.shutdown.begin();
  bench.pass(9);
  EXPECT_FALSE(bench.shutdown.is_done());
  bench.pass(50);
  EXPECT_TRUE(bench.shutdown.is_done());
  EXPECT_FALSE(bench.engine.has_power());
}

TEST(Shutdown, ChangesToAQuickStopAfterASecond) {
  ClosingBench bench;
  bench.move(100);  // 10 s
  bench.shutdown.begin();
  bench.pass(1'000);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27) << "still on the ramp of 605Ch";
  bench.pass(2);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x07) << "Quick stop active";
}

TEST(Shutdown, EndsAfterASecondAndAHalfAtTheLatest) {
  ClosingBench bench;
  bench.move(100);
  bench.shutdown.begin();
  bench.pass(1'500);
  EXPECT_FALSE(bench.shutdown.is_done());
  bench.pass(1);
  EXPECT_TRUE(bench.shutdown.is_done());
}

TEST(Shutdown, CountsFromTheFirstRequest) {
  ClosingBench bench;
  bench.move(100);
  bench.shutdown.begin();
  bench.pass(1'400);
  bench.shutdown.begin();
  bench.pass(101);
  EXPECT_TRUE(bench.shutdown.is_done());
}

TEST(Shutdown, OfAPausedBenchEndsAtOnce) {
  ClosingBench bench(with_clock(ClockMode::realtime, 0.0));
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.shutdown.begin();
  bench.shutdown.advance();
  EXPECT_TRUE(bench.shutdown.is_done());
}

}  // namespace
}  // namespace vdrive::test
