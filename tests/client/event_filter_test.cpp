// SPDX-License-Identifier: Apache-2.0
// Which events are new to a program.
#include "streams/event_filter.hpp"

#include "vdrive/client/event.hpp"
#include "vdrive/wire/event_name.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

namespace vdrive::client {
namespace {

constexpr BenchKey kRun{1, 10};

msg::Event event(std::uint64_t tick, std::uint32_t code, const BenchKey& run = kRun) {
  msg::Event event;
  event.bench(run.number);
  event.incarnation(run.incarnation);
  event.tick(tick);
  event.kind(msg::EVENT_FAULT);
  event.code(code);
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

TEST(EventKind, HasTheNameThatTheLogUses) {
  EXPECT_EQ(to_string(EventKind::fault_reset), "fault_reset");
  EXPECT_EQ(to_string(EventKind::stopped), "stopped");
  EXPECT_EQ(to_string(static_cast<EventKind>(9'999)), "unknown");
}

/// @return the name of the enumerator, as the compiler writes it.
template <EventKind kKind>
std::string_view enumerator() {
  std::string_view text = __PRETTY_FUNCTION__;
  text.remove_prefix(text.rfind("EventKind::") + std::string_view("EventKind::").size());
  return text.substr(0, text.find_first_of(";]"));
}

template <std::size_t... kPlaces>
auto enumerators(std::index_sequence<kPlaces...> /*places*/) {
  return std::array{enumerator<static_cast<EventKind>(kPlaces + 1)>()...};
}

TEST(EventKinds, AreCalledAsInTheWireContract) {
  const auto names = enumerators(std::make_index_sequence<wire::kEventKinds.size()>());
  for (std::size_t place = 0; place < names.size(); ++place) {
    EXPECT_EQ(names[place], wire::kEventKinds[place].name);
    EXPECT_EQ(wire::kEventKinds[place].kind, place + 1);
  }
}

}  // namespace
}  // namespace vdrive::client
