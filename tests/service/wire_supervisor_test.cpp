// SPDX-License-Identifier: Apache-2.0
#include "supervision/wire_supervisor.hpp"

#include "seam/doorbell.hpp"
#include "seam/wire_region.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;
using Cause = WireLoss::Cause;

constexpr std::uint64_t kLimit = 100ULL << 20U;
constexpr WireJudge::Time kSpawned{1'000s};

struct HealthyWire {
  WireJudge::Health health{.is_running = true};

  WireJudge::Health next() {
    ++health.pump_beats;
    ++health.probe_beats;
    return health;
  }
};

TEST(WireJudge, KeepsAHealthyWire) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.note_start(kSpawned);
  for (auto time = 0s; time < 60s; time += 1s) {
    ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned + time).has_value());
  }
}

TEST(WireJudge, EndsAWireThatDoesNotStart) {
  WireJudge judge(kLimit);
  judge.note_start(kSpawned);
  for (auto time = 0ms; time <= WireJudge::kLongestStart; time += 100ms) {
    ASSERT_FALSE(judge.reason_to_end({}, kSpawned + time).has_value());
  }
  const auto loss = judge.reason_to_end({}, kSpawned + WireJudge::kLongestStart + 1ms);
  ASSERT_TRUE(loss.has_value());
  EXPECT_EQ(loss->cause, Cause::no_start);
}

TEST(WireJudge, EndsAWireWhosePumpsStandStill) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.note_start(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  ++wire.health.probe_beats;
  for (auto time = 0ms; time <= WireJudge::kLongestRound; time += 100ms) {
    ASSERT_FALSE(judge.reason_to_end(wire.health, kSpawned + time).has_value());
  }
  const auto loss = judge.reason_to_end(wire.health, kSpawned + WireJudge::kLongestRound + 1ms);
  ASSERT_TRUE(loss.has_value());
  EXPECT_EQ(loss->cause, Cause::hangs);
}

TEST(WireJudge, EndsAWireThatNoProbeReachesWithinFiveSeconds) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.note_start(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  auto time = 0ms;
  std::optional<WireLoss> loss;
  while (!loss && time < 10s) {
    time += 10ms;
    ++wire.health.pump_beats;
    loss = judge.reason_to_end(wire.health, kSpawned + time);
  }
  ASSERT_TRUE(loss.has_value());
  EXPECT_EQ(loss->cause, Cause::deaf);
  EXPECT_LT(time, 5s);
}

TEST(WireJudge, EndsAWireThatUsesMoreThanItsMemory) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.note_start(kSpawned);
  wire.health.resident = kLimit;
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  wire.health.resident = kLimit + (1U << 20U);
  const auto loss = judge.reason_to_end(wire.next(), kSpawned);
  ASSERT_TRUE(loss.has_value());
  EXPECT_EQ(loss->cause, Cause::memory);
  EXPECT_EQ(loss->value, 101U);
}

TEST(WireJudge, WantsALookAtAProcessThatIsSilentAndAgainWhileItIs) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.note_start(kSpawned);
  const auto looks_until = [&](std::chrono::milliseconds end) {
    int examinations = 0;
    for (auto time = 0ms; time < end; time += 5ms) {
      static_cast<void>(judge.reason_to_end(wire.health, kSpawned + time));
      examinations += judge.needs_examination(kSpawned + time) ? 1 : 0;
    }
    return examinations;
  };
  EXPECT_EQ(looks_until(WireJudge::kLateRound), 0);
  EXPECT_NEAR(looks_until(1'000ms), 9, 1);
  ++wire.health.pump_beats;
  static_cast<void>(judge.reason_to_end(wire.health, kSpawned + 2s));
  EXPECT_FALSE(judge.needs_examination(kSpawned + 2s)) << "it was heard";
}

TEST(WireJudge, WantsALookAtAProcessThatDoesNotStart) {
  WireJudge judge(kLimit);
  judge.note_start(kSpawned);
  EXPECT_FALSE(judge.needs_examination(kSpawned + WireJudge::kLateRound));
  EXPECT_TRUE(judge.needs_examination(kSpawned + WireJudge::kLateRound + 1ms));
}

// The next wire starts immediately, then after 100, 200, 400 ms and so on up to 5 s. After a long
// run of a wire the delays start over.
TEST(WireJudge, WaitsLongerAfterEachFurtherEnd) {
  WireJudge judge(kLimit);
  std::vector<std::chrono::milliseconds> delays;
  for (int count = 0; count < 9; ++count) {
    judge.note_start(kSpawned);
    delays.push_back(std::chrono::duration_cast<std::chrono::milliseconds>(
        judge.note_end(kSpawned, false) - kSpawned));
  }
  EXPECT_EQ(delays,
            (std::vector{0ms, 100ms, 200ms, 400ms, 800ms, 1'600ms, 3'200ms, 5'000ms, 5'000ms}));
  HealthyWire wire;
  judge.note_start(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  EXPECT_EQ(judge.note_end(kSpawned + WireJudge::kLongRun, false), kSpawned + WireJudge::kLongRun);
}

// A debugger, a stop from the terminal or a suspended machine may pause the service. The supervisor
// checked nothing during that time.
TEST(WireJudge, AllowsAPauseOfTheWholeService) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.note_start(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  EXPECT_FALSE(judge.reason_to_end(wire.health, kSpawned + 60s).has_value());
}

TEST(WireJudge, WaitsAfterAWireThatItHadToEnd) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.note_start(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  EXPECT_EQ(judge.note_end(kSpawned + 5s, true), kSpawned + 5s) << "the first time at once";
  judge.note_start(kSpawned + 5s);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned + 5s).has_value());
  EXPECT_EQ(judge.note_end(kSpawned + 10s, true), kSpawned + 10s + WireJudge::kFirstDelay);
}

TEST(WireLoss, DescribesItsCause) {
  EXPECT_EQ((WireLoss{.cause = Cause::signal, .value = 6}).text(), "ended by signal 6 (Aborted)");
  EXPECT_EQ((WireLoss{.cause = Cause::exit_code, .value = 3}).text(), "ended with exit code 3");
}

TEST(WireRegion, IsTheSameMemoryThroughItsDescriptor) {
  const WireRegion region({.network = {.domain = 7, .peers = {"10.0.0.1"}}, .bench = 3});
  const WireRegion other = WireRegion::attach(dup(region.descriptor()));
  EXPECT_EQ(other.settings().bench, 3U);
  EXPECT_EQ(other.settings().network.domain, 7U);
  EXPECT_EQ(other.settings().network.peers, std::vector<std::string>{"10.0.0.1"});
  ByteRing producer = region.ring(Lane::replies);
  ByteRing consumer = other.ring(Lane::replies);
  ASSERT_TRUE(producer.reserve(5).has_value());
  producer.commit({.size = 5, .full_size = 5, .topic = 1, .flags = 0, .party = {}});
  EXPECT_EQ(consumer.size(), 1U);
  EXPECT_EQ(other.ring(Lane::reports).size(), 0U);
}

TEST(SharedSources, ContainThePresentSources) {
  const WireRegion region(WireSettings{});
  SharedSources& sources = region.control().readers;
  const wire::Source first{{1, 2, 3}};
  const wire::Source second{{4, 5, 6}};
  EXPECT_FALSE(sources.may_contain(first));
  sources.show({first, second});
  EXPECT_TRUE(sources.may_contain(first));
  EXPECT_TRUE(sources.may_contain(second));
  sources.show({second});
  EXPECT_FALSE(sources.may_contain(first));
}

TEST(Doorbell, RemembersARingWithoutAWaitingThread) {
  BellState state;
  Doorbell ringing(state);
  Doorbell waiting(state);
  EXPECT_FALSE(waiting.wait_for(0ms));
  ringing.ring();
  EXPECT_TRUE(waiting.wait_for(0ms));
  EXPECT_FALSE(waiting.wait_for(1ms)) << "one ring, one answer";
}

TEST(Doorbell, WakesAnotherThread) {
  BellState state;
  std::thread other([&] {
    Doorbell(state).ring();
  });
  EXPECT_TRUE(Doorbell(state).wait_for(10s));
  other.join();
}

}  // namespace
}  // namespace vdrive::service
