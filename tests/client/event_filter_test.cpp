// SPDX-License-Identifier: Apache-2.0
// Which events a program has not yet seen.
#include "streams/event_filter.hpp"

#include "vdrive/client/event.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace vdrive::client {
namespace {

constexpr BenchKey kRun{1, 10};

msg::Event event(std::uint64_t tick, std::uint32_t code, const BenchKey& run = kRun) {
  msg::Event event;
  event.bench = run.number;
  event.incarnation = run.incarnation;
  event.tick = tick;
  event.kind = msg::EventKind::fault;
  event.code = code;
  return event;
}

TEST(EventFilter, PassesNoEventOfARunBeforeItsBegin) {
  EventFilter sut;
  EXPECT_FALSE(sut.knows(kRun));
  EXPECT_FALSE(sut.passes(event(5, 1)));
}

TEST(EventFilter, HoldsBackHistory) {
  EventFilter sut;
  sut.begin(kRun, 100);
  EXPECT_FALSE(sut.passes(event(99, 1)));
  EXPECT_TRUE(sut.passes(event(100, 1)));
}

TEST(EventFilter, PassesARepeatedEventOnce) {
  EventFilter sut;
  sut.begin(kRun, 0);
  EXPECT_TRUE(sut.passes(event(7, 1)));
  EXPECT_TRUE(sut.passes(event(7, 2))) << "another one of the same tick";
  EXPECT_FALSE(sut.passes(event(7, 1)));
  EXPECT_FALSE(sut.passes(event(7, 2)));
  EXPECT_TRUE(sut.passes(event(6, 1))) << "the last of many equal ones is sent late";
}

TEST(EventFilter, RemembersAsManyEventsAsABenchRepeats) {
  EventFilter sut;
  sut.begin(kRun, 0);
  for (std::uint64_t tick = 0; tick < EventFilter::kRemembered; ++tick) {
    EXPECT_TRUE(sut.passes(event(tick, 1)));
  }
  EXPECT_FALSE(sut.passes(event(0, 1)));
  EXPECT_TRUE(sut.passes(event(EventFilter::kRemembered, 1)));
  EXPECT_TRUE(sut.passes(event(0, 1))) << "forgotten";
}

TEST(EventFilter, ForgetsThePreviousRun) {
  EventFilter sut;
  const BenchKey next{1, 11};
  const BenchKey other{2, 5};
  sut.begin(kRun, 0);
  sut.begin(other, 0);
  sut.begin(next, 0);
  EXPECT_FALSE(sut.knows(kRun));
  EXPECT_TRUE(sut.knows(other)) << "another bench";
  EXPECT_TRUE(sut.passes(event(1, 1, next)));
}

}  // namespace
}  // namespace vdrive::client
