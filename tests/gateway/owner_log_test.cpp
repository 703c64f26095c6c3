// SPDX-License-Identifier: Apache-2.0
#include "owner_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace vdrive::gateway {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint64_t kPageSession = 0xA;
constexpr std::uint64_t kToolSession = 0xB;
constexpr std::uint64_t kTakenTick = 50'000;
constexpr std::uint32_t kEpoch = 7;

// The format of a bench's report: the gaining session has a new epoch, the losing one has 0; axis 0
// means several axes.
client::Event control_event(std::uint16_t axis, std::uint64_t session, std::uint32_t epoch,
                            std::uint64_t tick = kTakenTick) {
  client::Event event;
  event.axis = axis;
  event.kind = client::EventKind::control_changed;
  event.session = session;
  event.code = epoch;
  event.tick = tick;
  return event;
}

client::Observation observation_of(const std::vector<std::uint64_t>& owners) {
  client::Observation observation;
  for (const std::uint64_t owner : owners) {
    observation.axes.emplace_back();
    observation.axes.back().owner_session = owner;
  }
  return observation;
}

TEST(OwnerLog, HasTheOwnersThatAStatusShowsOnceEachTheNewestLast) {
  OwnerLog sut;
  sut.note(observation_of({kPageSession, 0, kPageSession, kToolSession}));
  sut.note(observation_of({0, 0, 0, kPageSession}));
  EXPECT_THAT(sut.sessions(), ElementsAre(kToolSession, kPageSession));
  EXPECT_THAT(sut.takings(), IsEmpty());
}

TEST(OwnerLog, HasAnOwnerThatNoStatusShowed) {
  OwnerLog sut;
  sut.note(control_event(2, kPageSession, 0));
  sut.note(control_event(2, kToolSession, kEpoch));
  sut.note(control_event(2, kToolSession, 0));
  EXPECT_THAT(sut.sessions(), ElementsAre(kToolSession));
  EXPECT_THAT(sut.takings(), ElementsAre(Taking{2, kPageSession, kToolSession, kTakenTick}));
}

TEST(OwnerLog, HasEachOfSeveralAxesThatWereTakenAtOnce) {
  OwnerLog sut;
  sut.note(control_event(1, kPageSession, 0));
  sut.note(control_event(3, kPageSession, 0));
  sut.note(control_event(0, kToolSession, kEpoch));
  EXPECT_THAT(sut.takings(), ElementsAre(Taking{1, kPageSession, kToolSession, kTakenTick},
                                         Taking{3, kPageSession, kToolSession, kTakenTick}));
}

TEST(OwnerLog, HasNoTakingOfAnAxisThatWasFreeForATick) {
  OwnerLog sut;
  sut.note(control_event(2, kPageSession, 0));
  sut.note(control_event(2, kToolSession, kEpoch, kTakenTick + 1));
  EXPECT_THAT(sut.takings(), IsEmpty());
}

TEST(OwnerLog, HasNoTakingOfAnotherAxis) {
  OwnerLog sut;
  sut.note(control_event(2, kPageSession, 0));
  sut.note(control_event(1, kToolSession, kEpoch));
  EXPECT_THAT(sut.takings(), IsEmpty());
}

// Otherwise a page that took its axis back, then lost it to no other session, would name the
// earlier one.
TEST(OwnerLog, ForgetsATakingWhenTheAxisIsTakenBack) {
  OwnerLog sut;
  sut.note(control_event(2, kPageSession, 0));
  sut.note(control_event(2, kToolSession, kEpoch));
  sut.note(control_event(2, kPageSession, kEpoch + 1, kTakenTick + 1));
  EXPECT_THAT(sut.takings(), IsEmpty());
}

TEST(OwnerLog, ForgetsTheOldestOfTooMany) {
  OwnerLog sut;
  for (std::uint16_t axis = 1; axis <= OwnerLog::kMost + 1; ++axis) {
    sut.note(control_event(axis, kPageSession, 0));
    sut.note(control_event(axis, kToolSession + axis, kEpoch));
  }
  ASSERT_EQ(sut.takings().size(), OwnerLog::kMost);
  EXPECT_EQ(sut.takings().front().axis, 2);
  EXPECT_EQ(sut.sessions().size(), OwnerLog::kMost);
}

}  // namespace
}  // namespace vdrive::gateway
