// SPDX-License-Identifier: Apache-2.0
#include "seam/byte_ring.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace vdrive::service {
namespace {

constexpr std::uint64_t kAlignment = 8;
constexpr std::uint32_t kSkip = 0xFFFF'FFFF;  ///< as a size: the rest of the memory is unused

/// An empty ring restarts at the beginning of its memory once it has got this far [bytes]: a ring
/// that is seldom full uses few pages, which stay in the caches.
constexpr std::size_t kRewind = std::size_t{64} * 1024;

constexpr std::uint64_t aligned(std::uint64_t size) noexcept {
  return (size + kAlignment - 1) / kAlignment * kAlignment;
}

static_assert(sizeof(RecordHead) % kAlignment == 0);

}  // namespace

ByteRing::ByteRing(RingPositions& positions, std::span<std::byte> memory) noexcept
    : positions_(positions),
      memory_(memory),
      written_(positions.written.load(std::memory_order_acquire)),
      begin_(std::min(positions.begin.load(std::memory_order_relaxed), written_)),
      read_(positions.read.load(std::memory_order_acquire)) {
  ensure(std::has_single_bit(memory.size()), "the memory of a ring is a power of two");
}

/// A restart of the empty ring at its beginning is noted in RingPositions::begin and not by a mark
/// in the memory: until the reader had passed such a mark, the room after it could not be used.
std::optional<std::span<std::byte>> ByteRing::reserve(std::size_t size) noexcept {
  const std::uint64_t needed = sizeof(RecordHead) + aligned(size);
  const std::uint64_t read = std::max(positions_.read.load(std::memory_order_acquire), begin_);
  const std::uint64_t used = written_ - read;
  if (used > memory_.size()) return std::nullopt;  // the other side is broken
  const std::size_t place = offset(written_);
  const std::uint64_t to_end = memory_.size() - place;
  rewinds_ = used == 0 && (place >= kRewind || needed > to_end);
  const bool skips = !rewinds_ && needed > to_end;
  if (memory_.size() - used < needed + (skips ? to_end : 0)) return std::nullopt;
  if (skips) std::memcpy(&memory_[place], &kSkip, sizeof kSkip);
  reserved_ = written_ + (skips || rewinds_ ? to_end : 0);
  reserved_size_ = size;
  return memory_.subspan(offset(reserved_) + sizeof(RecordHead), size);
}

void ByteRing::commit(const RecordHead& head) noexcept {
  ensure(reserved_ >= written_, "a reserved room is handed over once");
  ensure(head.size <= reserved_size_, "a record ends inside the room that was reserved for it");
  std::memcpy(&memory_[offset(reserved_)], &head, sizeof head);
  if (rewinds_) {
    begin_ = reserved_;
    positions_.begin.store(begin_, std::memory_order_relaxed);
  }
  written_ = reserved_ + sizeof head + aligned(head.size);
  positions_.records_written.fetch_add(1, std::memory_order_relaxed);
  positions_.written.store(written_, std::memory_order_release);
}

std::optional<ByteRing::Record> ByteRing::front() noexcept {
  const std::uint64_t written = positions_.written.load(std::memory_order_acquire);
  if (read_ == written) return std::nullopt;
  const std::uint64_t begin = positions_.begin.load(std::memory_order_relaxed);
  if (begin > read_ && begin < written && offset(begin) == 0) read_ = begin;
  while (read_ != written) {
    const std::uint64_t waiting = written - read_;
    if (waiting > memory_.size() || waiting % kAlignment != 0) {
      clear();  // the other side is broken
      return std::nullopt;
    }
    const std::size_t place = offset(read_);
    const std::uint64_t to_end = memory_.size() - place;
    Record record;
    std::uint32_t size = 0;
    std::memcpy(&size, &memory_[place], sizeof size);
    if (size == kSkip && to_end < waiting) {
      read_ += to_end;
      continue;
    }
    const std::uint64_t needed = sizeof(RecordHead) + aligned(size);
    if (needed > waiting || needed > to_end) {
      clear();
      return std::nullopt;
    }
    std::memcpy(&record.head, &memory_[place], sizeof(RecordHead));
    record.head.size = size;
    record.bytes = memory_.subspan(place + sizeof(RecordHead), size);
    front_end_ = read_ + needed;
    return record;
  }
  return std::nullopt;
}

void ByteRing::pop() noexcept {
  ensure(front_end_ > read_, "a record was at the front");
  read_ = front_end_;
  positions_.records_read.fetch_add(1, std::memory_order_relaxed);
  positions_.read.store(read_, std::memory_order_release);
}

void ByteRing::clear() noexcept {
  positions_.records_read.store(positions_.records_written.load(std::memory_order_acquire),
                                std::memory_order_relaxed);
  read_ = positions_.written.load(std::memory_order_acquire) / kAlignment * kAlignment;
  positions_.read.store(read_, std::memory_order_release);
}

std::size_t ByteRing::size() const noexcept {
  const std::uint64_t read = positions_.records_read.load(std::memory_order_acquire);
  const std::uint64_t written = positions_.records_written.load(std::memory_order_acquire);
  return written > read ? static_cast<std::size_t>(written - read) : 0;
}

std::size_t ByteRing::bytes() const noexcept {
  const std::uint64_t written = positions_.written.load(std::memory_order_acquire);
  // After a restart at the beginning of the memory, the bytes before `begin` are not records.
  const std::uint64_t read = std::max(positions_.read.load(std::memory_order_acquire),
                                      positions_.begin.load(std::memory_order_relaxed));
  return written > read ? static_cast<std::size_t>(written - read) : 0;
}

}  // namespace vdrive::service
