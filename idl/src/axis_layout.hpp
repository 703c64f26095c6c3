// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "status_members.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive/wire/status_frame.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

/// The AxisStatus of the IDL as bytes, alone or in a sequence: copied between status images and
/// samples, without a message object between them.
namespace vdrive::wire {

static_assert(std::endian::native == std::endian::little,
              "status samples are copied as they stand in memory and announced as CDR_LE");

using Image = std::array<std::byte, sizeof(AxisStatus)>;

/// What is in front of the members of the status image, in the order of the IDL; the gaps align the
/// member behind them.
template <std::size_t kGapBeforeTick>
struct [[gnu::packed]] AxisHead {
  std::uint32_t bench;
  std::uint16_t axis;
  std::array<std::byte, kGapBeforeTick> gap_before_tick;
  std::uint64_t tick;
  std::uint64_t owner_session;
  std::uint32_t owner_epoch;
  std::uint32_t gap_before_last_sequence;
  std::uint64_t last_sequence;
};

/// Bytes that stand side by side in the image and in a sample.
struct Piece {
  std::size_t in_image = 0;
  std::size_t in_sample = 0;  ///< from the end of the head
  std::size_t size = 0;       ///< 0 = no piece
};

/// The members of the status image in a sample: what kWireStatusMembers says.
struct MemberLayout {
  std::array<Piece, std::tuple_size_v<decltype(kWireStatusMembers)>> pieces{};
  std::size_t count = 0;  ///< of `pieces`
  std::size_t gaps = 0;   ///< that align the member behind them
  std::size_t gap = 0;    ///< where the last one begins, from the end of the head
  std::size_t gap_size = 0;
  std::size_t size = 0;  ///< of all
};

/// @return where the member is in an image: that of an image with 1 in every bit of it.
template <typename Number>
constexpr std::size_t place_in_image(Number AxisStatus::*member) {
  AxisStatus status;
  status.*member = static_cast<Number>(-1);
  const auto image = std::bit_cast<Image>(status);
  return static_cast<std::size_t>(std::ranges::find(image, std::byte{0xFF}) - image.begin());
}

/// CDR aligns a number to its size. Members that follow each other in image and sample are one
/// piece: one copy, not one for each.
constexpr MemberLayout layout_of_members() {
  MemberLayout layout;
  for_each_status_member([&layout]<typename Number>(Number AxisStatus::*member, const auto&) {
    const std::size_t aligned =
        (layout.size + sizeof(Number) - 1) / sizeof(Number) * sizeof(Number);
    if (aligned != layout.size) {
      ++layout.gaps;
      layout.gap = layout.size;
      layout.gap_size = aligned - layout.size;
    }
    const Piece next{
        .in_image = place_in_image(member), .in_sample = aligned, .size = sizeof(Number)};
    Piece* const last = layout.count == 0 ? nullptr : &layout.pieces[layout.count - 1];
    if (last != nullptr && last->in_image + last->size == next.in_image &&
        last->in_sample + last->size == next.in_sample) {
      last->size += next.size;
    } else {
      layout.pieces[layout.count++] = next;
    }
    layout.size = aligned + sizeof(Number);
  });
  return layout;
}

inline constexpr MemberLayout kMembers = layout_of_members();
static_assert(kMembers.gaps == 1, "put_axis fills one gap with zeros");

/// Calls `visit` with each piece, known to the compiler: the copies become single instructions.
template <typename Visit>
void for_each_piece(const Visit& visit) noexcept {
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    (visit(std::integral_constant<std::size_t, kIndex>{}), ...);
  }
  (std::make_index_sequence<kMembers.count>{});
}

template <typename Head>
constexpr std::size_t kSizeWith = sizeof(Head) + kMembers.size;

// An axis that begins at a multiple of 8, and one that begins 4 bytes behind one. Both end alike:
// the head ends at a multiple of 8.
using AlignedAxis = AxisHead<2>;
using ShiftedAxis = AxisHead<6>;
inline constexpr std::size_t kEnd = kSizeWith<AlignedAxis> % 8;
static_assert(kEnd % 4 == 0, "the member `bench` of the next axis follows without a gap");
static_assert(offsetof(AlignedAxis, tick) % 8 == 0 && sizeof(AlignedAxis) % 8 == 0 &&
              (4 + offsetof(ShiftedAxis, tick)) % 8 == 0 && (4 + sizeof(ShiftedAxis)) % 8 == 0);
static_assert(kEncapsulation + kSizeWith<AlignedAxis> == kAxisStatusSize);

/// Straight to its place: a copy of what was just written in small pieces would have to wait.
template <typename Head>
void put_axis(const AxisStatus& status, const AxisAddress& address, std::uint64_t tick,
              const Ownership& owner, std::byte* place) noexcept {
  const auto put = [place](std::size_t offset, const auto& value) {
    std::memcpy(place + offset, &value, sizeof value);
  };
  put(offsetof(Head, bench), address.bench);
  put(offsetof(Head, axis), address.axis);
  put(offsetof(Head, gap_before_tick), decltype(Head::gap_before_tick){});
  put(offsetof(Head, tick), tick);
  put(offsetof(Head, owner_session), owner.session);
  put(offsetof(Head, owner_epoch), owner.epoch);
  put(offsetof(Head, gap_before_last_sequence), std::uint32_t{0});
  put(offsetof(Head, last_sequence), owner.last_sequence);
  put(sizeof(Head) + kMembers.gap, std::array<std::byte, kMembers.gap_size>{});
  const std::byte* const image = std::as_bytes(std::span(&status, 1)).data();
  for_each_piece([&](auto index) {
    constexpr Piece kPiece = kMembers.pieces[index];
    std::memcpy(place + sizeof(Head) + kPiece.in_sample, image + kPiece.in_image, kPiece.size);
  });
}

/// Straight to its place, as put_axis. What a sample does not have stays as it is.
template <typename Head>
void get_axis(const std::byte* place, ReceivedStatus& received) noexcept {
  const auto get = [place](std::size_t offset, auto& value) {
    std::memcpy(&value, place + offset, sizeof value);
  };
  get(offsetof(Head, bench), received.address.bench);
  get(offsetof(Head, axis), received.address.axis);
  get(offsetof(Head, tick), received.tick);
  get(offsetof(Head, owner_session), received.owner.session);
  get(offsetof(Head, owner_epoch), received.owner.epoch);
  get(offsetof(Head, last_sequence), received.owner.last_sequence);
  std::byte* const image = std::as_writable_bytes(std::span(&received.status, 1)).data();
  for_each_piece([&](auto index) {
    constexpr Piece kPiece = kMembers.pieces[index];
    std::memcpy(image + kPiece.in_image, place + sizeof(Head) + kPiece.in_sample, kPiece.size);
  });
}

/// Axes of a sequence that follow each other.
class AxisSequence {
 public:
  /// @param begin of the first axis, from the end of the encapsulation: a multiple of 4
  explicit constexpr AxisSequence(std::size_t begin) noexcept : is_aligned_(begin % 8 == 0) {}

  /// @return where axis `position` begins, from the beginning of the first one; that of the last
  ///         one plus 1 is the size of all.
  [[nodiscard]] constexpr std::size_t place_of(std::size_t position) const noexcept {
    if (position == 0) return 0;
    return size_of(is_aligned_) + (position - 1) * size_of(kEnd == 0);
  }

  void put(std::size_t position, const AxisStatus& status, const AxisAddress& address,
           std::uint64_t tick, const Ownership& owner, std::byte* first) const noexcept {
    std::byte* const place = first + place_of(position);
    if (is_aligned(position)) {
      put_axis<AlignedAxis>(status, address, tick, owner, place);
    } else {
      put_axis<ShiftedAxis>(status, address, tick, owner, place);
    }
  }

  /// What a sample does not have of the status stays as it is.
  void get(std::size_t position, const std::byte* first, ReceivedStatus& received) const noexcept {
    const std::byte* const place = first + place_of(position);
    if (is_aligned(position)) {
      get_axis<AlignedAxis>(place, received);
    } else {
      get_axis<ShiftedAxis>(place, received);
    }
  }

 private:
  static constexpr std::size_t size_of(bool is_aligned) noexcept {
    return is_aligned ? kSizeWith<AlignedAxis> : kSizeWith<ShiftedAxis>;
  }

  /// The first axis begins where the sequence does, each other one where an axis ends.
  [[nodiscard]] constexpr bool is_aligned(std::size_t position) const noexcept {
    return position == 0 ? is_aligned_ : kEnd == 0;
  }

  bool is_aligned_;  ///< the sequence, to 8
};

}  // namespace vdrive::wire
