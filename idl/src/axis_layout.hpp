// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "status_fields.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive/wire/status_frame.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

/// The AxisStatus of the IDL as bytes, alone or in a sequence, copied directly between status
/// images and samples without a message object. The position of each member follows from its
/// description.
namespace vdrive::wire {

static_assert(std::endian::native == std::endian::little,
              "status samples are copied as they stand in memory and announced as CDR_LE");

/// Bytes that are contiguous both in the status image and in a sample.
struct Piece {
  std::size_t in_image = 0;
  std::size_t in_sample = 0;
  std::size_t size = 0;
};

/// An axis in a sample: the positions of the bytes of the status image, and the padding before
/// members. All offsets are from the start of the axis.
struct AxisLayout {
  std::array<Piece, kStatusMembers> pieces{};
  std::size_t count = 0;        ///< of `pieces`
  std::array<Piece, 4> gaps{};  ///< `in_image` is not used
  std::size_t gap_count = 0;
  std::size_t size = 0;
};

/// Members that are contiguous in both image and sample form one piece, which takes a single copy.
constexpr AxisLayout layout_of_axis(std::size_t begin) {
  AxisLayout layout;
  for_each_member<msg::AxisStatus>(
      [&]<typename Number>(const Member<msg::AxisStatus, Number>& member) {
        const std::size_t gap = cdr_gap(begin + layout.size, sizeof(Number));
        if (gap != 0) layout.gaps.at(layout.gap_count++) = {.in_sample = layout.size, .size = gap};
        layout.size += gap;
        if (const auto in_image = place_in_image(member.name)) {
          Piece* const last = layout.count == 0 ? nullptr : &layout.pieces[layout.count - 1];
          if (last != nullptr && last->in_image + last->size == *in_image &&
              last->in_sample + last->size == layout.size) {
            last->size += sizeof(Number);
          } else {
            layout.pieces.at(layout.count++) = {
                .in_image = *in_image, .in_sample = layout.size, .size = sizeof(Number)};
          }
        }
        layout.size += sizeof(Number);
      });
  return layout;
}

/// The layout of an axis that starts at a multiple of 8 bytes (kBegin = 0), or 4 bytes after one
/// (4).
template <std::size_t kBegin>
inline constexpr AxisLayout kAxisLayout = layout_of_axis(kBegin);

// Both layouts end at the same alignment.
inline constexpr std::size_t kEnd = kAxisLayout<0>.size % 8;
static_assert(kEnd % 4 == 0 && (4 + kAxisLayout<4>.size) % 8 == kEnd,
              "the member `bench` of the next axis follows without a gap");
static_assert(kEncapsulation + kAxisLayout<0>.size == kAxisStatusSize);

/// Offsets of the members before the status image, from the start of the axis.
template <std::size_t kBegin>
struct AxisPlaces {
  static constexpr std::size_t kBench = place_of_member<msg::AxisStatus>("bench", kBegin);
  static constexpr std::size_t kAxis = place_of_member<msg::AxisStatus>("axis", kBegin);
  static constexpr std::size_t kTick = place_of_member<msg::AxisStatus>("tick", kBegin);
  static constexpr std::size_t kSession = place_of_member<msg::AxisStatus>("owner_session", kBegin);
  static constexpr std::size_t kEpoch = place_of_member<msg::AxisStatus>("owner_epoch", kBegin);
  static constexpr std::size_t kSequence =
      place_of_member<msg::AxisStatus>("last_sequence", kBegin);
};

/// Calls `visit(kIndex)` with each index below `kCount` as a compile-time constant, so that the
/// copies become single instructions.
template <std::size_t kCount, typename Visit>
constexpr void for_each_index(const Visit& visit) noexcept {
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    (visit(std::integral_constant<std::size_t, kIndex>{}), ...);
  }
  (std::make_index_sequence<kCount>{});
}

/// Writes an axis directly to its position: a second copy would have to wait for the small writes
/// just made.
template <std::size_t kBegin>
void put_axis(const AxisStatus& status, const AxisAddress& address, std::uint64_t tick,
              const Ownership& owner, std::byte* place) noexcept {
  const auto put = [place](std::size_t offset, const auto& value) {
    std::memcpy(place + offset, &value, sizeof value);
  };
  using Places = AxisPlaces<kBegin>;
  put(Places::kBench, address.bench);
  put(Places::kAxis, address.axis);
  put(Places::kTick, tick);
  put(Places::kSession, owner.session);
  put(Places::kEpoch, owner.epoch);
  put(Places::kSequence, owner.last_sequence);
  for_each_index<kAxisLayout<kBegin>.gap_count>([&](auto index) {
    constexpr Piece kGap = kAxisLayout<kBegin>.gaps[index];
    put(kGap.in_sample, std::array<std::byte, kGap.size>{});
  });
  const std::byte* const image = std::as_bytes(std::span(&status, 1)).data();
  for_each_index<kAxisLayout<kBegin>.count>([&](auto index) {
    constexpr Piece kPiece = kAxisLayout<kBegin>.pieces[index];
    std::memcpy(place + kPiece.in_sample, image + kPiece.in_image, kPiece.size);
  });
}

/// Reads an axis directly, like put_axis. Members that the sample does not have stay unchanged.
template <std::size_t kBegin>
void get_axis(const std::byte* place, ReceivedStatus& received) noexcept {
  const auto get = [place](std::size_t offset, auto& value) {
    std::memcpy(&value, place + offset, sizeof value);
  };
  using Places = AxisPlaces<kBegin>;
  get(Places::kBench, received.address.bench);
  get(Places::kAxis, received.address.axis);
  get(Places::kTick, received.tick);
  get(Places::kSession, received.owner.session);
  get(Places::kEpoch, received.owner.epoch);
  get(Places::kSequence, received.owner.last_sequence);
  std::byte* const image = std::as_writable_bytes(std::span(&received.status, 1)).data();
  for_each_index<kAxisLayout<kBegin>.count>([&](auto index) {
    constexpr Piece kPiece = kAxisLayout<kBegin>.pieces[index];
    std::memcpy(image + kPiece.in_image, place + kPiece.in_sample, kPiece.size);
  });
}

/// Consecutive axes of a sequence.
class AxisSequence {
 public:
  /// @param begin start of the first axis, from the end of the encapsulation; a multiple of 4
  explicit constexpr AxisSequence(std::size_t begin) noexcept : is_aligned_(begin % 8 == 0) {}

  /// @return the offset of axis `position` from the start of the first one; if `position` is the
  ///         number of axes, the total size.
  [[nodiscard]] constexpr std::size_t place_of(std::size_t position) const noexcept {
    if (position == 0) return 0;
    return size_of(is_aligned_) + (position - 1) * size_of(kEnd == 0);
  }

  void put(std::size_t position, const AxisStatus& status, const AxisAddress& address,
           std::uint64_t tick, const Ownership& owner, std::byte* first) const noexcept {
    std::byte* const place = first + place_of(position);
    if (is_aligned(position)) {
      put_axis<0>(status, address, tick, owner, place);
    } else {
      put_axis<4>(status, address, tick, owner, place);
    }
  }

  /// Members of the status that the sample does not have stay unchanged.
  void get(std::size_t position, const std::byte* first, ReceivedStatus& received) const noexcept {
    const std::byte* const place = first + place_of(position);
    if (is_aligned(position)) {
      get_axis<0>(place, received);
    } else {
      get_axis<4>(place, received);
    }
  }

 private:
  static constexpr std::size_t size_of(bool is_aligned) noexcept {
    return is_aligned ? kAxisLayout<0>.size : kAxisLayout<4>.size;
  }

  /// The first axis starts where the sequence does, each further one where the previous one ends.
  /// All axes end at the same alignment (kEnd).
  [[nodiscard]] constexpr bool is_aligned(std::size_t position) const noexcept {
    return position == 0 ? is_aligned_ : kEnd == 0;
  }

  bool is_aligned_;  ///< whether the sequence is aligned to 8
};

}  // namespace vdrive::wire
