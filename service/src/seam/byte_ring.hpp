// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/source.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace vdrive::service {

struct RecordHead {
  std::uint32_t size = 0;  ///< of the bytes that follow
  /// The size of the complete sample. If it is larger than `size`, only the beginning of the sample
  /// follows; if it is smaller, other data follow the sample.
  std::uint32_t full_size = 0;
  std::uint16_t topic = 0;  ///< wire::TopicId
  std::uint16_t flags = 0;  ///< kForOne
  wire::Source party;       ///< the sender; with kForOne, the receiver

  /// Flag: the record is an answer, which waits until its receiver can be reached.
  static constexpr std::uint16_t kForOne = 1;
};

/// The counters of a ring, in memory shared by both sides. They only grow.
struct RingPositions {
  static constexpr std::size_t kCacheLine = 64;

  alignas(kCacheLine) std::atomic<std::uint64_t> written{0};  ///< [bytes]
  std::atomic<std::uint64_t> begin{0};  ///< set by the producer: no records from `read` up to here
  std::atomic<std::uint64_t> records_written{0};
  alignas(kCacheLine) std::atomic<std::uint64_t> read{0};  ///< [bytes]
  std::atomic<std::uint64_t> records_read{0};
};

/// Bounded queue of byte records from one producer to one consumer, in memory that two processes
/// may share. No locks, allocations or system calls. Neither side trusts the other: positions and
/// sizes are checked before use, and a ring with invalid positions counts as empty.
class ByteRing {
 public:
  /// The record at the front of the ring; valid until `pop`.
  struct Record {
    RecordHead head;
    std::span<const std::byte> bytes;
  };

  /// @param positions in the shared memory, initially zero
  /// @param memory its size is a power of two [bytes], aligned to 8
  ByteRing(RingPositions& positions, std::span<std::byte> memory) noexcept;

  /// Producer: @return contiguous room for `size` bytes, or nullopt if the ring is full.
  [[nodiscard]] std::optional<std::span<std::byte>> reserve(std::size_t size) noexcept;

  /// Producer: hands over the room of the last `reserve`, of which `head.size` bytes were used.
  void commit(const RecordHead& head) noexcept;

  /// Consumer: @return the oldest record, or nullopt.
  [[nodiscard]] std::optional<Record> front() noexcept;

  /// Consumer: frees the room of `front`.
  void pop() noexcept;

  /// Consumer: drops all waiting records.
  void clear() noexcept;

  /// @return how many records wait; exact only when no thread uses the ring.
  [[nodiscard]] std::size_t size() const noexcept;

  /// @return how many bytes the waiting records take; exact only when no thread uses the ring.
  [[nodiscard]] std::size_t bytes() const noexcept;

  [[nodiscard]] std::size_t capacity() const noexcept { return memory_.size(); }

 private:
  [[nodiscard]] std::size_t offset(std::uint64_t position) const noexcept {
    return static_cast<std::size_t>(position) & (memory_.size() - 1);
  }

  RingPositions& positions_;
  std::span<std::byte> memory_;
  std::uint64_t written_ = 0;   ///< the producer's private copy
  std::uint64_t reserved_ = 0;  ///< where the reserved record begins
  std::size_t reserved_size_ = 0;
  std::uint64_t begin_ = 0;  ///< the producer's private copy
  bool rewinds_ = false;     ///< the reserved record begins at the start of the memory
  std::uint64_t read_ = 0;   ///< the consumer's private copy
  std::uint64_t front_end_ = 0;
};

}  // namespace vdrive::service
