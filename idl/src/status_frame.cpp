// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/status_frame.hpp"

#include "axis_layout.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string_view>

namespace vdrive::wire {
namespace {

/// The offset of a member of the frame in a sample.
constexpr std::size_t place_of(std::string_view name) {
  return kEncapsulation + place_of_member<msg::StatusFrame>(name);
}

constexpr std::size_t kPlaceOfBench = place_of("bench");
constexpr std::size_t kPlaceOfSkippedTicks = place_of("skipped_ticks");
constexpr std::size_t kPlaceOfIncarnation = place_of("incarnation");
constexpr std::size_t kPlaceOfTick = place_of("tick");
constexpr std::size_t kPlaceOfTimeNs = place_of("time_ns");
constexpr std::size_t kPlaceOfPart = place_of("part");
constexpr std::size_t kPlaceOfParts = place_of("parts");
constexpr std::size_t kPlaceOfAxes = place_of("axes");
constexpr std::size_t kFirst = kPlaceOfAxes + sizeof(std::uint32_t);
constexpr AxisSequence kAxes(kFirst - kEncapsulation);

}  // namespace

std::size_t encoded_status_frame_size(std::size_t axes) noexcept {
  return kFirst + kAxes.place_of(axes);
}

std::size_t encode_status_frame(const StatusFrameHead& head, const AxesAfterTick& axes,
                                std::span<std::byte> output) noexcept {
  const std::size_t count = axes.status.size();
  ensure(axes.owners.size() == count && axes.numbers.size() == count,
         "each axis has a status, an owner and a number");
  const std::size_t size = encoded_status_frame_size(count);
  if (output.size() < size) return 0;
  std::byte* const sample = output.data();
  const auto put = [sample](std::size_t place, const auto& value) {
    std::memcpy(sample + place, &value, sizeof value);
  };
  put(0, kLittleEndian);
  put(kPlaceOfBench, head.bench);
  put(kPlaceOfSkippedTicks, head.skipped_ticks);
  put(kPlaceOfIncarnation, head.incarnation);
  put(kPlaceOfTick, head.tick);
  put(kPlaceOfTimeNs, head.time_ns);
  put(kPlaceOfPart, head.part);
  put(kPlaceOfParts, head.parts);
  put(kPlaceOfAxes, static_cast<std::uint32_t>(count));
  std::byte* const first = sample + kFirst;
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
  put_axis<0>(status, address, tick, owner, &output[kEncapsulation]);
  return kAxisStatusSize;
}

std::optional<StatusFrameView> StatusFrameView::of(std::span<const std::byte> sample) noexcept {
  // Ignore the last two bytes of the encapsulation: they are options, which plain CDR does not use.
  if (sample.size() < kFirst ||
      !std::equal(kLittleEndian.begin(), kLittleEndian.begin() + 2, sample.begin())) {
    return std::nullopt;
  }
  const auto get = [&sample](std::size_t place, auto& value) {
    std::memcpy(&value, &sample[place], sizeof value);
  };
  std::uint32_t axes = 0;
  get(kPlaceOfAxes, axes);
  if (axes > msg::MAX_AXES_PER_FRAME || sample.size() < encoded_status_frame_size(axes)) {
    return std::nullopt;
  }
  StatusFrameView view;
  get(kPlaceOfBench, view.head_.bench);
  get(kPlaceOfSkippedTicks, view.head_.skipped_ticks);
  get(kPlaceOfIncarnation, view.head_.incarnation);
  get(kPlaceOfTick, view.head_.tick);
  get(kPlaceOfTimeNs, view.head_.time_ns);
  get(kPlaceOfPart, view.head_.part);
  get(kPlaceOfParts, view.head_.parts);
  view.size_ = axes;
  view.axes_ = sample.subspan(kFirst);
  return view;
}

std::uint16_t StatusFrameView::number(std::size_t position) const noexcept {
  constexpr std::size_t kNumber = place_of_member<msg::AxisStatus>("axis");
  static_assert(kNumber == place_of_member<msg::AxisStatus>("axis", 4));
  ensure(position < size_, "the frame has that many axes");
  std::uint16_t number = 0;
  std::memcpy(&number, &axes_[kAxes.place_of(position) + kNumber], sizeof number);
  return number;
}

ReceivedStatus StatusFrameView::axis(std::size_t position) const noexcept {
  ensure(position < size_, "the frame has that many axes");
  ReceivedStatus received;
  kAxes.get(position, axes_.data(), received);
  return received;
}

}  // namespace vdrive::wire
