// SPDX-License-Identifier: Apache-2.0
#include "doorbell.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 40s;

class DoorbellOfEachKind : public testing::TestWithParam<Doorbell::Waiting> {
 protected:
  BellState state_;
  Doorbell sut_{state_, GetParam()};
};

TEST_P(DoorbellOfEachKind, RemembersARingWhileNobodyWaits) {
  sut_.ring();
  EXPECT_TRUE(sut_.wait_for(kPatience));
  EXPECT_FALSE(sut_.wait_for(0ns)) << "each ring is heard once";
}

TEST_P(DoorbellOfEachKind, HearsSeveralRingsAsOne) {
  sut_.ring();
  sut_.ring();
  EXPECT_TRUE(sut_.wait_for(kPatience));
  EXPECT_FALSE(sut_.wait_for(0ns));
}

TEST_P(DoorbellOfEachKind, SaysWhenNoRingCame) {
  sut_.ring();
  EXPECT_TRUE(sut_.wait_for(kPatience)) << "the next wait of the quick kind looks first";
  EXPECT_FALSE(sut_.wait_for(1ms));
}

// A ring that is lost between looking and sleeping would end this in a time-out.
TEST_P(DoorbellOfEachKind, HearsEveryRingOfAnotherThreadThatWaitsToBeHeard) {
  constexpr int kRings = 2'000;
  std::atomic<int> heard{0};
  std::jthread visitor([&] {
    Doorbell other(state_);
    for (int rung = 0; rung < kRings; ++rung) {
      other.ring();
      heard.wait(rung);
    }
  });
  int ring = 0;
  while (ring < kRings && sut_.wait_for(kPatience)) {
    heard = ++ring;
    heard.notify_one();
  }
  EXPECT_EQ(ring, kRings);
  heard = kRings;  // lets the visitor end also after a failure
  heard.notify_one();
}

INSTANTIATE_TEST_SUITE_P(Waiting, DoorbellOfEachKind,
                         testing::Values(Doorbell::Waiting::asleep, Doorbell::Waiting::quick),
                         [](const auto& waiting) {
                           return waiting.param == Doorbell::Waiting::quick ? "quick" : "asleep";
                         });

}  // namespace
}  // namespace vdrive::service
