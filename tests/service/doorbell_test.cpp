// SPDX-License-Identifier: Apache-2.0
#include "seam/doorbell.hpp"

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

TEST_P(DoorbellOfEachKind, RemembersARingWhileNoThreadWaits) {
  sut_.ring();
  EXPECT_TRUE(sut_.wait_for(kPatience));
  EXPECT_FALSE(sut_.wait_for(0ns)) << "each ring is received once";
}

TEST_P(DoorbellOfEachKind, CountsSeveralRingsAsOne) {
  sut_.ring();
  sut_.ring();
  EXPECT_TRUE(sut_.wait_for(kPatience));
  EXPECT_FALSE(sut_.wait_for(0ns));
}

TEST_P(DoorbellOfEachKind, ReportsATimeOutWithoutARing) {
  sut_.ring();
  EXPECT_TRUE(sut_.wait_for(kPatience)) << "the next wait of the quick kind checks first";
  EXPECT_FALSE(sut_.wait_for(1ms));
}

// A ring lost between check and sleep would end this test in a time-out.
TEST_P(DoorbellOfEachKind, ReceivesEveryRingOfAnotherThread) {
  constexpr int kRings = 2'000;
  std::atomic<int> received{0};
  std::jthread visitor([&] {
    Doorbell other(state_);
    for (int rung = 0; rung < kRings; ++rung) {
      other.ring();
      received.wait(rung);
    }
  });
  int ring = 0;
  while (ring < kRings && sut_.wait_for(kPatience)) {
    received = ++ring;
    received.notify_one();
  }
  EXPECT_EQ(ring, kRings);
  received = kRings;  // the visitor must end after a failure, too
  received.notify_one();
}

INSTANTIATE_TEST_SUITE_P(Waiting, DoorbellOfEachKind,
                         testing::Values(Doorbell::Waiting::asleep, Doorbell::Waiting::quick),
                         [](const auto& waiting) {
                           return waiting.param == Doorbell::Waiting::quick ? "quick" : "asleep";
                         });

}  // namespace
}  // namespace vdrive::service
