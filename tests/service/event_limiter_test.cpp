// SPDX-License-Identifier: Apache-2.0
#include "base/event_limiter.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

TEST(EventLimiter, PassesDifferentEvents) {
  EventLimiter limiter;
  std::vector<CountedEvent> passed;
  for (std::uint16_t axis = 1; axis <= 1'000; ++axis) {
    limiter.offer({.kind = msg::EventKind::fault, .axis = axis}, 0ns, passed);
  }
  EXPECT_EQ(passed.size(), 1'000U);
}

TEST(EventLimiter, CountsEqualEventsThatItLeavesOut) {
  constexpr std::uint32_t kOffered = 500;
  EventLimiter limiter;
  std::vector<CountedEvent> passed;
  for (std::uint32_t count = 0; count < kOffered; ++count) {
    limiter.offer({.kind = msg::EventKind::refused, .code = 3}, 1ms * count / 10, passed);
  }
  // Only the burst passes. At 20 events per second, none becomes due in the 49 ms of the offers.
  EXPECT_EQ(passed.size(), 20U);
  limiter.flush(2s, passed);
  const std::uint32_t suppressed =
      std::accumulate(passed.begin(), passed.end(), 0U, [](std::uint32_t sum, const auto& event) {
        return sum + static_cast<std::uint32_t>(event.suppressed);
      });
  EXPECT_EQ(passed.size() + suppressed, kOffered);
}

TEST(EventLimiter, AddsTheCountToTheNextEqualEvent) {
  EventLimiter limiter;
  std::vector<CountedEvent> passed;
  for (std::uint32_t count = 0; count < 20 + 7; ++count) {
    limiter.offer({.kind = msg::EventKind::refused}, 0ns, passed);
  }
  passed.clear();
  limiter.offer({.kind = msg::EventKind::refused}, 3s, passed);
  ASSERT_EQ(passed.size(), 1U);
  EXPECT_EQ(passed[0].suppressed, 7U);
}

TEST(EventLimiter, IsBoundedAgainstAFloodOfDifferentEvents) {
  EventLimiter limiter;
  std::vector<CountedEvent> passed;
  for (std::uint64_t session = 0; session < 100'000; ++session) {
    limiter.offer({.kind = msg::EventKind::refused, .session = session}, 0ns, passed);
  }
  EXPECT_LE(passed.size(), 8'000U);
}

}  // namespace
}  // namespace vdrive::service
