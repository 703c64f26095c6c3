// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/source.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace vdrive::service {

/// What stands in front of the bytes of a record.
struct RecordHead {
  std::uint32_t size = 0;  ///< of the bytes that follow
  /// Of the whole sample: above `size` only its beginning follows, below `size` something else
  /// follows behind it.
  std::uint32_t full_size = 0;
  std::uint16_t topic = 0;  ///< wire::TopicId
  std::uint16_t flags = 0;  ///< kForOne
  wire::Source party;       ///< who sent it; with kForOne, who has to get it

  /// The record is an answer: it waits until its receiver can be reached.
  static constexpr std::uint16_t kForOne = 1;
};

/// The counters of a ring, in the memory that both sides share. They only grow.
struct RingPositions {
  static constexpr std::size_t kCacheLine = 64;

  alignas(kCacheLine) std::atomic<std::uint64_t> written{0};  ///< [bytes]
  std::atomic<std::uint64_t> begin{0};  ///< the producer's; nothing is between `read` and it
  std::atomic<std::uint64_t> records_written{0};
  alignas(kCacheLine) std::atomic<std::uint64_t> read{0};  ///< [bytes]
  std::atomic<std::uint64_t> records_read{0};
};

/// Bounded queue of records of bytes from one producer to one consumer, in memory that two
/// processes may share. No lock, no allocation, no system call. Neither side trusts what the other
/// side wrote: positions and sizes are checked before use, and a ring with invalid positions counts
/// as empty.
class ByteRing {
 public:
  /// A record at the front of the ring; valid until `pop`.
  struct Record {
    RecordHead head;
    std::span<const std::byte> bytes;
  };

  /// @param positions in the shared memory, zero at the beginning
  /// @param memory of a power of two of bytes, aligned to 8
  ByteRing(RingPositions& positions, std::span<std::byte> memory) noexcept;

  /// Producer: @return room for `size` bytes in one piece, or nothing when the ring is full.
  [[nodiscard]] std::optional<std::span<std::byte>> reserve(std::size_t size) noexcept;

  /// Producer: hands over the room of the last `reserve`, of which `head.size` bytes were used.
  void commit(const RecordHead& head) noexcept;

  /// Consumer: @return the oldest record, or nothing.
  [[nodiscard]] std::optional<Record> front() noexcept;

  /// Consumer: gives the room of `front` back.
  void pop() noexcept;

  /// Consumer: drops all that waits.
  void clear() noexcept;

  /// @return how many records wait; exact only when no thread uses the ring.
  [[nodiscard]] std::size_t size() const noexcept;

  /// @return how many bytes they take; exact only when no thread uses the ring.
  [[nodiscard]] std::size_t bytes() const noexcept;

  [[nodiscard]] std::size_t capacity() const noexcept { return memory_.size(); }

 private:
  [[nodiscard]] std::size_t offset(std::uint64_t position) const noexcept {
    return static_cast<std::size_t>(position) & (memory_.size() - 1);
  }

  RingPositions& positions_;
  std::span<std::byte> memory_;
  std::uint64_t written_ = 0;   ///< the producer's own
  std::uint64_t reserved_ = 0;  ///< where the reserved record begins
  std::size_t reserved_size_ = 0;
  std::uint64_t begin_ = 0;  ///< the producer's own
  bool rewinds_ = false;     ///< the reserved record begins at the start of the memory
  std::uint64_t read_ = 0;   ///< the consumer's own
  std::uint64_t front_end_ = 0;
};

}  // namespace vdrive::service
