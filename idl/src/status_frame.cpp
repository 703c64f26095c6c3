// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/status_frame.hpp"

#include "status_members.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive_messages.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <tuple>
#include <type_traits>
#include <utility>

namespace vdrive::wire {
namespace {

static_assert(std::endian::native == std::endian::little,
              "status samples are copied as they stand in memory and announced as CDR_LE");

constexpr std::array<std::byte, kEncapsulation> kLittleEndian{std::byte{0}, std::byte{1},
                                                              std::byte{0}, std::byte{0}};

struct FrameLayout {
  std::uint32_t bench;
  std::uint32_t skipped_ticks;
  std::uint64_t incarnation;
  std::uint64_t tick;
  std::int64_t time_ns;
  std::uint16_t part;
  std::uint16_t parts;
  std::uint32_t axes;  ///< length of the sequence
};

static_assert(sizeof(FrameLayout) == 40 && std::is_trivially_copyable_v<FrameLayout>);

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

constexpr MemberLayout kMembers = layout_of_members();
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

// The first axis of a frame begins at a multiple of 8, every further one where an axis ends.
using FirstAxis = AxisHead<2>;
constexpr std::size_t kEnd = kSizeWith<FirstAxis> % 8;
static_assert(kEnd % 4 == 0, "the member `bench` of the next axis follows without a gap");
using FurtherAxis = AxisHead<kEnd == 4 ? 6 : 2>;
static_assert(offsetof(FirstAxis, tick) % 8 == 0 && sizeof(FirstAxis) % 8 == 0 &&
              (kEnd + offsetof(FurtherAxis, tick)) % 8 == 0 &&
              (kEnd + kSizeWith<FurtherAxis>) % 8 == kEnd);
static_assert(kEncapsulation + kSizeWith<FirstAxis> == kAxisStatusSize);

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

template <typename Head>
ReceivedStatus axis_at(const std::byte* place) noexcept {
  Head head{};
  std::memcpy(&head, place, sizeof head);
  ReceivedStatus received{.address = {.bench = head.bench, .axis = head.axis},
                          .tick = head.tick,
                          .owner = {.session = head.owner_session,
                                    .epoch = head.owner_epoch,
                                    .last_sequence = head.last_sequence},
                          .status = {}};
  std::byte* const image = std::as_writable_bytes(std::span(&received.status, 1)).data();
  for_each_piece([&](auto index) {
    constexpr Piece kPiece = kMembers.pieces[index];
    std::memcpy(image + kPiece.in_image, place + sizeof(Head) + kPiece.in_sample, kPiece.size);
  });
  return received;
}

/// Where an axis begins, behind the first one's beginning.
constexpr std::size_t place_of(std::size_t position) noexcept {
  return position == 0 ? 0 : kSizeWith<FirstAxis> + (position - 1) * kSizeWith<FurtherAxis>;
}

}  // namespace

std::size_t encoded_status_frame_size(std::size_t axes) noexcept {
  return kEncapsulation + sizeof(FrameLayout) + place_of(axes);
}

std::size_t encode_status_frame(const StatusFrameHead& head, const AxesAfterTick& axes,
                                std::span<std::byte> output) noexcept {
  const std::size_t count = axes.status.size();
  ensure(axes.owners.size() == count && axes.numbers.size() == count,
         "each axis has a status, an owner and a number");
  const std::size_t size = encoded_status_frame_size(count);
  if (output.size() < size) return 0;
  const FrameLayout frame{.bench = head.bench,
                          .skipped_ticks = head.skipped_ticks,
                          .incarnation = head.incarnation,
                          .tick = head.tick,
                          .time_ns = head.time_ns,
                          .part = head.part,
                          .parts = head.parts,
                          .axes = static_cast<std::uint32_t>(count)};
  std::byte* const place = output.data();
  std::memcpy(place, kLittleEndian.data(), kEncapsulation);
  std::memcpy(place + kEncapsulation, &frame, sizeof frame);
  std::byte* const first = place + kEncapsulation + sizeof frame;
  for (std::size_t axis = 0; axis < count; ++axis) {
    const auto put = axis == 0 ? put_axis<FirstAxis> : put_axis<FurtherAxis>;
    put(axes.status[axis], {head.bench, axes.numbers[axis]}, head.tick, axes.owners[axis],
        first + place_of(axis));
  }
  return size;
}

std::size_t encode_axis_status(const AxisStatus& status, const AxisAddress& address,
                               std::uint64_t tick, const Ownership& owner,
                               std::span<std::byte> output) noexcept {
  if (output.size() < kAxisStatusSize) return 0;
  std::memcpy(output.data(), kLittleEndian.data(), kEncapsulation);
  put_axis<FirstAxis>(status, address, tick, owner, &output[kEncapsulation]);
  return kAxisStatusSize;
}

std::optional<StatusFrameView> StatusFrameView::of(std::span<const std::byte> sample) noexcept {
  constexpr std::size_t kFirst = kEncapsulation + sizeof(FrameLayout);
  // The last two bytes of the encapsulation are options, which plain CDR does not have.
  if (sample.size() < kFirst ||
      !std::equal(kLittleEndian.begin(), kLittleEndian.begin() + 2, sample.begin())) {
    return std::nullopt;
  }
  FrameLayout frame{};
  std::memcpy(&frame, &sample[kEncapsulation], sizeof frame);
  if (frame.axes > msg::MAX_AXES_PER_FRAME ||
      sample.size() < encoded_status_frame_size(frame.axes)) {
    return std::nullopt;
  }
  StatusFrameView view;
  view.head_ = {.bench = frame.bench,
                .skipped_ticks = frame.skipped_ticks,
                .incarnation = frame.incarnation,
                .tick = frame.tick,
                .time_ns = frame.time_ns,
                .part = frame.part,
                .parts = frame.parts};
  view.size_ = frame.axes;
  view.axes_ = sample.subspan(kFirst);
  return view;
}

std::uint16_t StatusFrameView::number(std::size_t position) const noexcept {
  static_assert(offsetof(FirstAxis, axis) == offsetof(FurtherAxis, axis));
  ensure(position < size_, "the frame has that many axes");
  std::uint16_t number = 0;
  std::memcpy(&number, &axes_[place_of(position) + offsetof(FirstAxis, axis)], sizeof number);
  return number;
}

ReceivedStatus StatusFrameView::axis(std::size_t position) const noexcept {
  ensure(position < size_, "the frame has that many axes");
  const std::byte* const place = &axes_[place_of(position)];
  return position == 0 ? axis_at<FirstAxis>(place) : axis_at<FurtherAxis>(place);
}

}  // namespace vdrive::wire
