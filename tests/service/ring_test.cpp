// SPDX-License-Identifier: Apache-2.0
#include "ring.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>
#include <vector>

namespace vdrive::service {
namespace {

void put_number(Ring<int>& ring, int value) {
  int* const slot = ring.free_slot();
  ASSERT_NE(slot, nullptr);
  *slot = value;
  ring.push();
}

TEST(Ring, GivesMessagesBackInTheirOrder) {
  Ring<int> ring(3);
  for (int round = 0; round < 5; ++round) {
    put_number(ring, round);
    put_number(ring, round + 100);
    EXPECT_EQ(*ring.front(), round);
    ring.pop();
    EXPECT_EQ(*ring.front(), round + 100);
    ring.pop();
    EXPECT_EQ(ring.front(), nullptr);
  }
}

TEST(Ring, HoldsAsManyAsItsCapacityAndNoMore) {
  Ring<int> ring(2);
  put_number(ring, 1);
  put_number(ring, 2);
  EXPECT_EQ(ring.free_slot(), nullptr);
  EXPECT_EQ(ring.size(), 2U);
  ring.pop();
  EXPECT_NE(ring.free_slot(), nullptr);
}

TEST(Ring, KeepsTheCapacityOfItsSlots) {
  Ring<std::vector<int>> ring(1);
  ring.for_each_slot([](auto& slot) {
    slot.reserve(100);
  });
  for (int round = 0; round < 4; ++round) {
    ASSERT_NE(ring.free_slot(), nullptr);
    EXPECT_GE(ring.free_slot()->capacity(), 100U);
    ring.free_slot()->clear();
    ring.push();
    ring.pop();
  }
}

TEST(Ring, LosesNothingBetweenTwoThreads) {
  constexpr std::uint64_t kMessages = 100'000;
  Ring<std::uint64_t> ring(64);
  std::thread producer([&] {
    for (std::uint64_t message = 1; message <= kMessages;) {
      if (std::uint64_t* const slot = ring.free_slot(); slot != nullptr) {
        *slot = message++;
        ring.push();
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::uint64_t expected = 1;
  while (expected <= kMessages) {
    if (const std::uint64_t* const message = ring.front(); message != nullptr) {
      ASSERT_EQ(*message, expected);
      ++expected;
      ring.pop();
    } else {
      std::this_thread::yield();
    }
  }
  producer.join();
}

}  // namespace
}  // namespace vdrive::service
