// SPDX-License-Identifier: Apache-2.0
#include "seam/byte_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

namespace vdrive::service {
namespace {

constexpr std::size_t kHead = sizeof(RecordHead);

struct Memory {
  explicit Memory(std::size_t size) : words(size / sizeof(std::uint64_t)) {}

  ByteRing end() { return {positions, std::as_writable_bytes(std::span(words))}; }

  RingPositions positions;
  std::vector<std::uint64_t> words;
};

/// Puts a record of `size` bytes, each of them `value`.
bool put(ByteRing& ring, std::size_t size, std::uint8_t value) {
  const auto room = ring.reserve(size);
  if (!room) return false;
  std::fill(room->begin(), room->end(), std::byte{value});
  ring.commit({.size = static_cast<std::uint32_t>(size),
               .full_size = static_cast<std::uint32_t>(size),
               .topic = value,
               .flags = 0,
               .party = {}});
  return true;
}

bool is_whole(const ByteRing::Record& record, std::size_t size, std::uint8_t value) {
  return record.head.topic == value && record.bytes.size() == size &&
         std::all_of(record.bytes.begin(), record.bytes.end(), [&](std::byte byte) {
           return byte == std::byte{value};
         });
}

// A record of 10 bytes takes 16 after its head: records begin at multiples of 8.
TEST(ByteRing, CountsTheRecordsThatWaitAndTheirBytes) {
  Memory memory(256);
  ByteRing producer = memory.end();
  ByteRing consumer = memory.end();
  EXPECT_EQ(consumer.bytes(), 0U);
  ASSERT_TRUE(put(producer, 10, 1));
  ASSERT_TRUE(put(producer, 16, 2));
  EXPECT_EQ(consumer.size(), 2U);
  EXPECT_EQ(consumer.bytes(), 2 * (kHead + 16));
  ASSERT_TRUE(consumer.front());
  consumer.pop();
  EXPECT_EQ(consumer.size(), 1U);
  EXPECT_EQ(consumer.bytes(), kHead + 16);
  ASSERT_TRUE(consumer.front());
  consumer.pop();
  EXPECT_EQ(consumer.bytes(), 0U);
  ASSERT_TRUE(put(producer, 10, 3)) << "an empty ring begins anew";
  EXPECT_EQ(consumer.bytes(), kHead + 16);
}

TEST(ByteRing, GivesRecordsInTheirOrder) {
  Memory memory(256);
  ByteRing producer = memory.end();
  ByteRing consumer = memory.end();
  EXPECT_FALSE(consumer.front().has_value());
  ASSERT_TRUE(put(producer, 10, 1));
  ASSERT_TRUE(put(producer, 0, 2));
  EXPECT_EQ(consumer.size(), 2U);
  ASSERT_TRUE(is_whole(consumer.front().value(), 10, 1));
  consumer.pop();
  ASSERT_TRUE(is_whole(consumer.front().value(), 0, 2));
  consumer.pop();
  EXPECT_FALSE(consumer.front().has_value());
  EXPECT_EQ(producer.size(), 0U);
}

// A record of 40 bytes takes 24 + 40 = 64: four fill 256 bytes, a fifth has no room.
TEST(ByteRing, RefusesARecordWithoutRoomUntilOneIsTaken) {
  Memory memory(256);
  ByteRing producer = memory.end();
  ByteRing consumer = memory.end();
  for (std::uint8_t count = 0; count < 4; ++count) ASSERT_TRUE(put(producer, 64 - kHead, count));
  EXPECT_FALSE(put(producer, 0, 9));
  ASSERT_TRUE(consumer.front().has_value());
  consumer.pop();
  EXPECT_TRUE(put(producer, 64 - kHead, 4));
  EXPECT_FALSE(put(producer, 257, 9)) << "larger than the whole ring";
}

TEST(ByteRing, KeepsRecordsInOnePieceAcrossItsEnd) {
  Memory memory(256);
  ByteRing producer = memory.end();
  ByteRing consumer = memory.end();
  std::uint8_t value = 0;
  for (int round = 0; round < 1'000; ++round) {
    for (const std::size_t size : {1U, 17U, 100U, 63U}) {
      ASSERT_TRUE(put(producer, size, ++value)) << "round " << round << ", " << size << " bytes";
      ASSERT_TRUE(is_whole(consumer.front().value(), size, value)) << "round " << round;
      consumer.pop();
    }
  }
}

// The ring has room for 1 MiB. 16 MiB pass through it in records of 1,000 bytes, each read before
// the next is written, so only the first 64 KiB and the record across their end are used.
TEST(ByteRing, UsesFewPagesWhileItsReaderKeepsUp) {
  Memory memory(std::size_t{1} << 20U);
  ByteRing producer = memory.end();
  ByteRing consumer = memory.end();
  for (std::size_t count = 0; count < 16'384; ++count) {
    ASSERT_TRUE(put(producer, 1'000, static_cast<std::uint8_t>(count % 251)));
    const auto record = consumer.front();
    ASSERT_TRUE(record && is_whole(*record, 1'000, static_cast<std::uint8_t>(count % 251)));
    consumer.pop();
  }
  const auto touched = std::find_if(memory.words.rbegin(), memory.words.rend(), [](auto word) {
    return word != 0;
  });
  EXPECT_LE(std::distance(touched, memory.words.rend()) * 8, 64 * 1024 + 1'024);
}

// The producer fills the ring while the consumer takes nothing, from several positions. A record
// takes 1,032 bytes with its head, so 1,016 fit into 1 MiB (1,048,576 bytes), less one that may not
// fit before the end of the memory.
TEST(ByteRing, HasItsWholeCapacityFromAnyPosition) {
  constexpr std::size_t kRecord = 1'032;
  constexpr std::size_t kFit = (std::size_t{1} << 20U) / kRecord - 1;
  for (std::size_t before = 1; before <= 256; before += 15) {
    Memory memory(std::size_t{1} << 20U);
    ByteRing producer = memory.end();
    ByteRing consumer = memory.end();
    for (std::size_t count = 0; count < before; ++count) {
      ASSERT_TRUE(put(producer, kRecord - kHead, 1));
    }
    for (std::size_t count = 0; count < before; ++count) {
      ASSERT_TRUE(consumer.front().has_value());
      consumer.pop();
    }
    for (std::size_t count = 0; count < kFit; ++count) {
      ASSERT_TRUE(put(producer, kRecord - kHead, static_cast<std::uint8_t>(count % 251)))
          << "record " << count << " after " << before << " that were read";
    }
    for (std::size_t count = 0; count < kFit; ++count) {
      const auto record = consumer.front();
      ASSERT_TRUE(record &&
                  is_whole(*record, kRecord - kHead, static_cast<std::uint8_t>(count % 251)));
      consumer.pop();
    }
    EXPECT_FALSE(consumer.front().has_value());
  }
}

// Both ends are replaced while the ring is empty, full, and in between.
TEST(ByteRing, ContinuesForAReaderThatAttachesLater) {
  Memory memory(std::size_t{1} << 18U);
  for (int round = 0; round < 50; ++round) {
    {
      ByteRing producer = memory.end();
      static_cast<void>(producer.reserve(1'000));  // the previous producer ended here
    }
    ByteRing producer = memory.end();
    for (std::uint8_t count = 0; count < 100; ++count) ASSERT_TRUE(put(producer, 1'000, count));
    for (std::uint8_t count = 0; count < 100; ++count) {
      ByteRing consumer = memory.end();
      const auto record = consumer.front();
      ASSERT_TRUE(record && is_whole(*record, 1'000, count)) << "round " << round;
      consumer.pop();
    }
  }
}

TEST(ByteRing, IgnoresAForgedBeginning) {
  for (const std::uint64_t forged : {1ULL, 8ULL, 24ULL, 40ULL, 256ULL, 1ULL << 62U}) {
    Memory memory(256);
    ByteRing producer = memory.end();
    ByteRing consumer = memory.end();
    ASSERT_TRUE(put(producer, 8, 1));
    memory.positions.begin.store(forged);
    ASSERT_TRUE(is_whole(consumer.front().value(), 8, 1)) << forged;
    consumer.pop();
    ByteRing next_producer = memory.end();
    ASSERT_TRUE(put(next_producer, 8, 2)) << forged;
    ASSERT_TRUE(is_whole(consumer.front().value(), 8, 2)) << forged;
  }
}

TEST(ByteRing, ContinuesWhereAnEndedSideStopped) {
  Memory memory(256);
  {
    ByteRing producer = memory.end();
    ASSERT_TRUE(put(producer, 8, 1));
    static_cast<void>(producer.reserve(30));  // it ends while filling the record
  }
  ByteRing second = memory.end();
  ASSERT_TRUE(put(second, 8, 2));
  {
    ByteRing consumer = memory.end();
    ASSERT_TRUE(is_whole(consumer.front().value(), 8, 1));
    consumer.pop();
  }
  ByteRing consumer = memory.end();
  EXPECT_TRUE(is_whole(consumer.front().value(), 8, 2));
}

TEST(ByteRing, IsEmptyAfterInvalidPositionsOfTheOtherSide) {
  Memory memory(256);
  ByteRing producer = memory.end();
  ByteRing consumer = memory.end();
  ASSERT_TRUE(put(producer, 8, 1));
  memory.positions.written.store(1'000'000);  // more than fits
  EXPECT_FALSE(consumer.front().has_value());

  Memory forged(256);
  ByteRing good = forged.end();
  ASSERT_TRUE(put(good, 8, 1));
  constexpr std::uint32_t kAbsurd = 0xFFFF'FF00;
  std::memcpy(forged.words.data(), &kAbsurd, sizeof kAbsurd);
  ByteRing reader = forged.end();
  EXPECT_FALSE(reader.front().has_value());
  ASSERT_TRUE(put(good, 8, 2)) << "and it continues with the next record";
  EXPECT_TRUE(is_whole(reader.front().value(), 8, 2));
}

TEST(ByteRing, IsEmptyAtOnceAfterAForgedDistantPosition) {
  Memory memory(256);
  constexpr std::uint32_t kSkipRecord = 0xFFFF'FFFF;
  std::memcpy(memory.words.data(), &kSkipRecord, sizeof kSkipRecord);
  memory.positions.written.store(1ULL << 62U);
  EXPECT_FALSE(memory.end().front().has_value());
  Memory uneven(256);
  uneven.positions.written.store(7);
  ByteRing reader = uneven.end();
  EXPECT_FALSE(reader.front().has_value());
  ByteRing producer = uneven.end();
  EXPECT_EQ(uneven.positions.read.load() % 8, 0U) << "what is read next lies inside of the memory";
  static_cast<void>(producer);
}

TEST(ByteRing, HasNoRoomAfterInvalidPositionsOfTheReader) {
  Memory memory(256);
  ByteRing producer = memory.end();
  memory.positions.read.store(12'345);
  EXPECT_FALSE(producer.reserve(8).has_value());
}

TEST(ByteRing, LosesNothingBetweenTwoThreads) {
  constexpr int kRecords = 200'000;
  Memory memory(8'192);
  std::thread writer([&] {
    ByteRing producer = memory.end();
    std::minstd_rand random(1);
    for (int count = 0; count < kRecords;) {
      const std::size_t size = random() % 200;
      while (!put(producer, size, static_cast<std::uint8_t>(count))) std::this_thread::yield();
      ++count;
    }
  });
  ByteRing consumer = memory.end();
  std::minstd_rand random(1);
  int broken = 0;
  for (int count = 0; count < kRecords;) {
    const auto record = consumer.front();
    if (!record) {
      std::this_thread::yield();
      continue;
    }
    broken += is_whole(*record, random() % 200, static_cast<std::uint8_t>(count)) ? 0 : 1;
    consumer.pop();
    ++count;
  }
  writer.join();
  EXPECT_EQ(broken, 0);
}

}  // namespace
}  // namespace vdrive::service
