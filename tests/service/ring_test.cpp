// SPDX-License-Identifier: Apache-2.0
#include "base/ring.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>
#include <vector>

namespace vdrive::service {
namespace {

void put_in_ring(Ring<int>& ring, int value) {
  int* const slot = ring.free_slot();
  ASSERT_NE(slot, nullptr);
  *slot = value;
  ring.push();
}

TEST(Ring, ReturnsMessagesInTheirOrder) {
  Ring<int> ring(3);
  for (int round = 0; round < 5; ++round) {
    put_in_ring(ring, round);
    put_in_ring(ring, round + 100);
    EXPECT_EQ(*ring.front(), round);
    ring.pop();
    EXPECT_EQ(*ring.front(), round + 100);
    ring.pop();
    EXPECT_EQ(ring.front(), nullptr);
  }
}

TEST(Ring, HoldsExactlyItsCapacity) {
  Ring<int> ring(2);
  put_in_ring(ring, 1);
  put_in_ring(ring, 2);
  EXPECT_EQ(ring.free_slot(), nullptr);
  EXPECT_EQ(ring.size(), 2U);
  ring.pop();
  EXPECT_NE(ring.free_slot(), nullptr);
}

// Of 10 slots, one message at a time uses only the first, and three at a time only the first three.
TEST(Ring, RestartsWithItsFirstSlotWhenItIsEmpty) {
  Ring<int> ring(10);
  const int* const first = ring.free_slot();
  for (int round = 0; round < 25; ++round) {
    ASSERT_EQ(ring.free_slot(), first);
    put_in_ring(ring, round);
    put_in_ring(ring, round + 100);
    put_in_ring(ring, round + 200);
    for (int place = 0; place < 3; ++place) {
      EXPECT_EQ(ring.front(), first + place);
      EXPECT_EQ(*ring.front(), round + 100 * place);
      ring.pop();
    }
    EXPECT_EQ(ring.size(), 0U);
  }
}

// In each of 20 rounds the ring is filled from empty, and gets a message while one is left in it.
TEST(Ring, HasItsWholeCapacityFromAnyPosition) {
  Ring<int> ring(10);
  for (int round = 0; round < 20; ++round) {
    for (int count = 0; count < 1 + round % 10; ++count) put_in_ring(ring, count);
    while (ring.front() != nullptr) ring.pop();
    for (int count = 0; count < 10; ++count) put_in_ring(ring, count);
    EXPECT_EQ(ring.free_slot(), nullptr);
    EXPECT_EQ(ring.size(), 10U);
    for (int count = 0; count < 9; ++count) {
      EXPECT_EQ(*ring.front(), count);
      ring.pop();
    }
    put_in_ring(ring, 10);
    EXPECT_EQ(*ring.front(), 9);
    ring.pop();
    EXPECT_EQ(*ring.front(), 10);
    ring.pop();
  }
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

/// Counts constructions and destructions.
struct Counted {
  Counted() { ++made; }

  ~Counted() { ++ended; }

  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

  static inline int made = 0;   // NOLINT(*-avoid-non-const-global-variables)
  static inline int ended = 0;  // NOLINT(*-avoid-non-const-global-variables)
};

TEST(Ring, MakesOnlyTheSlotsThatAreUsed) {
  Counted::made = 0;
  Counted::ended = 0;
  {
    Ring<Counted> ring(1'000'000);
    EXPECT_EQ(Counted::made, 0);
    for (int round = 0; round < 3; ++round) {
      for (int message = 0; message < 2; ++message) {
        ASSERT_NE(ring.free_slot(), nullptr);
        ring.push();
      }
      ring.pop();
      ring.pop();
    }
    EXPECT_LE(Counted::made, 6) << "at most one for each message";
    EXPECT_GE(Counted::made, 2) << "two wait at once";
  }
  EXPECT_EQ(Counted::ended, Counted::made);
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
