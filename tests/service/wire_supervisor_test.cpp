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

/// A wire that does all that it should.
struct HealthyWire {
  WireJudge::Sight sight{.is_running = true};

  WireJudge::Sight next() {
    ++sight.pump_beats;
    ++sight.probe_beats;
    return sight;
  }
};

TEST(WireJudge, KeepsAHealthyWire) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.started(kSpawned);
  for (auto time = 0s; time < 60s; time += 1s) {
    ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned + time).has_value());
  }
}

TEST(WireJudge, EndsAWireThatDoesNotStart) {
  WireJudge judge(kLimit);
  judge.started(kSpawned);
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
  judge.started(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  ++wire.sight.probe_beats;
  for (auto time = 0ms; time <= WireJudge::kLongestRound; time += 100ms) {
    ASSERT_FALSE(judge.reason_to_end(wire.sight, kSpawned + time).has_value());
  }
  const auto loss = judge.reason_to_end(wire.sight, kSpawned + WireJudge::kLongestRound + 1ms);
  ASSERT_TRUE(loss.has_value());
  EXPECT_EQ(loss->cause, Cause::hangs);
}

TEST(WireJudge, EndsAWireThatNoProbeReachesWithinFiveSeconds) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.started(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  auto time = 0ms;
  std::optional<WireLoss> loss;
  while (!loss && time < 10s) {
    time += 10ms;
    ++wire.sight.pump_beats;
    loss = judge.reason_to_end(wire.sight, kSpawned + time);
  }
  ASSERT_TRUE(loss.has_value());
  EXPECT_EQ(loss->cause, Cause::deaf);
  EXPECT_LT(time, 5s);
}

TEST(WireJudge, EndsAWireThatUsesMoreThanItsMemory) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.started(kSpawned);
  wire.sight.resident = kLimit;
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  wire.sight.resident = kLimit + (1U << 20U);
  const auto loss = judge.reason_to_end(wire.next(), kSpawned);
  ASSERT_TRUE(loss.has_value());
  EXPECT_EQ(loss->cause, Cause::memory);
  EXPECT_EQ(loss->value, 101U);
}

TEST(WireJudge, WantsALookAtAProcessThatIsSilentAndAgainWhileItIs) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.started(kSpawned);
  const auto looks_until = [&](std::chrono::milliseconds end) {
    int looks = 0;
    for (auto time = 0ms; time < end; time += 5ms) {
      static_cast<void>(judge.reason_to_end(wire.sight, kSpawned + time));
      looks += judge.wants_look(kSpawned + time) ? 1 : 0;
    }
    return looks;
  };
  EXPECT_EQ(looks_until(WireJudge::kLateRound), 0);
  EXPECT_NEAR(looks_until(1'000ms), 9, 1);
  ++wire.sight.pump_beats;
  static_cast<void>(judge.reason_to_end(wire.sight, kSpawned + 2s));
  EXPECT_FALSE(judge.wants_look(kSpawned + 2s)) << "it was heard";
}

TEST(WireJudge, WantsALookAtAProcessThatDoesNotStart) {
  WireJudge judge(kLimit);
  judge.started(kSpawned);
  EXPECT_FALSE(judge.wants_look(kSpawned + WireJudge::kLateRound));
  EXPECT_TRUE(judge.wants_look(kSpawned + WireJudge::kLateRound + 1ms));
}

// At once, then after 100, 200, 400 ms and so on, 5 s at most; a long run makes it forget.
TEST(WireJudge, WaitsLongerAfterEachFurtherEnd) {
  WireJudge judge(kLimit);
  std::vector<std::chrono::milliseconds> delays;
  for (int count = 0; count < 9; ++count) {
    judge.started(kSpawned);
    delays.push_back(std::chrono::duration_cast<std::chrono::milliseconds>(
        judge.ended(kSpawned, false) - kSpawned));
  }
  EXPECT_EQ(delays,
            (std::vector{0ms, 100ms, 200ms, 400ms, 800ms, 1'600ms, 3'200ms, 5'000ms, 5'000ms}));
  HealthyWire wire;
  judge.started(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  EXPECT_EQ(judge.ended(kSpawned + WireJudge::kLongRun, false), kSpawned + WireJudge::kLongRun);
}

// A debugger, a terminal's stop, a machine that is suspended: the supervisor checked nothing
// meanwhile.
TEST(WireJudge, AllowsAPauseOfTheWholeService) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.started(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  EXPECT_FALSE(judge.reason_to_end(wire.sight, kSpawned + 60s).has_value());
}

TEST(WireJudge, WaitsAfterAWireThatItHadToEnd) {
  WireJudge judge(kLimit);
  HealthyWire wire;
  judge.started(kSpawned);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned).has_value());
  EXPECT_EQ(judge.ended(kSpawned + 5s, true), kSpawned + 5s) << "the first time at once";
  judge.started(kSpawned + 5s);
  ASSERT_FALSE(judge.reason_to_end(wire.next(), kSpawned + 5s).has_value());
  EXPECT_EQ(judge.ended(kSpawned + 10s, true), kSpawned + 10s + WireJudge::kFirstDelay);
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
