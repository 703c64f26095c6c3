// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/status_frame.hpp"

#include "axis_layout.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive_messages.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <type_traits>

namespace vdrive::wire {
namespace {

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

constexpr std::size_t kFirst = kEncapsulation + sizeof(FrameLayout);
constexpr AxisSequence kAxes(sizeof(FrameLayout));

}  // namespace

std::size_t encoded_status_frame_size(std::size_t axes) noexcept {
  return kEncapsulation + sizeof(FrameLayout) + kAxes.place_of(axes);
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
    kAxes.put(axis, axes.status[axis], {head.bench, axes.numbers[axis]}, head.tick,
              axes.owners[axis], first);
  }
  return size;
}

std::size_t encode_axis_status(const AxisStatus& status, const AxisAddress& address,
                               std::uint64_t tick, const Ownership& owner,
                               std::span<std::byte> output) noexcept {
  if (output.size() < kAxisStatusSize) return 0;
  std::memcpy(output.data(), kLittleEndian.data(), kEncapsulation);
  put_axis<AlignedAxis>(status, address, tick, owner, &output[kEncapsulation]);
  return kAxisStatusSize;
}

std::optional<StatusFrameView> StatusFrameView::of(std::span<const std::byte> sample) noexcept {
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
  static_assert(offsetof(AlignedAxis, axis) == offsetof(ShiftedAxis, axis));
  ensure(position < size_, "the frame has that many axes");
  std::uint16_t number = 0;
  std::memcpy(&number, &axes_[kAxes.place_of(position) + offsetof(AlignedAxis, axis)],
              sizeof number);
  return number;
}

ReceivedStatus StatusFrameView::axis(std::size_t position) const noexcept {
  ensure(position < size_, "the frame has that many axes");
  ReceivedStatus received;
  kAxes.get(position, axes_.data(), received);
  return received;
}

}  // namespace vdrive::wire
