// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/status_frame.hpp"

#include "vdrive/wire/codec.hpp"
#include "vdrive_messages.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <type_traits>

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

/// 6062h to 3575h, ten numbers that image and message have in the same order.
using Motion = std::array<std::int32_t, 10>;

constexpr std::size_t kMotion = offsetof(AxisStatus, position_demand_value);

constexpr bool is_in_motion(std::size_t place, std::size_t offset) noexcept {
  return offset == kMotion + place * sizeof(std::int32_t);
}

static_assert(is_in_motion(1, offsetof(AxisStatus, load_position_actual_value)) &&
              is_in_motion(2, offsetof(AxisStatus, load_position_error_value)) &&
              is_in_motion(3, offsetof(AxisStatus, motor_position_actual_value)) &&
              is_in_motion(4, offsetof(AxisStatus, motor_position_error_value)) &&
              is_in_motion(5, offsetof(AxisStatus, velocity_demand_value)) &&
              is_in_motion(6, offsetof(AxisStatus, load_velocity_actual_value)) &&
              is_in_motion(7, offsetof(AxisStatus, load_velocity_error_value)) &&
              is_in_motion(8, offsetof(AxisStatus, motor_velocity_actual_value)) &&
              is_in_motion(9, offsetof(AxisStatus, motor_velocity_error_value)));

std::span<const std::byte> bytes_of(const AxisStatus& status) noexcept {
  return std::as_bytes(std::span(&status, 1));
}

/// An axis in a sample, in the order of the IDL; the gaps align the member behind them.
template <std::size_t kGapBeforeTick>
struct [[gnu::packed]] AxisLayout {
  std::uint32_t bench;
  std::uint16_t axis;
  std::array<std::byte, kGapBeforeTick> gap_before_tick;
  std::uint64_t tick;
  std::uint64_t owner_session;
  std::uint32_t owner_epoch;
  std::uint32_t gap_before_last_sequence;
  std::uint64_t last_sequence;
  std::uint16_t ds402_statusword;
  std::int8_t op_mode_actual;
  std::uint8_t motor_op_status;
  std::uint16_t error_code;
  std::uint8_t error_register;
  std::uint8_t digital_inputs;
  Motion motion;
  std::int16_t current_actual_value;
  std::uint16_t gap_before_current_error_value;
  std::int32_t current_error_value;
  std::int16_t torque_demand;
  std::int16_t torque_actual_value;
  std::uint32_t ignored_set_points;
  std::uint32_t fault_count;
};

// The first axis of a frame begins at a multiple of 8. It ends 4 bytes behind one, and so does
// every further axis.
using FirstAxis = AxisLayout<2>;
using FurtherAxis = AxisLayout<6>;
static_assert(sizeof(FirstAxis) == 108 && sizeof(FurtherAxis) == 112);
static_assert(offsetof(FirstAxis, tick) % 8 == 0 &&
              (sizeof(FirstAxis) + offsetof(FurtherAxis, tick)) % 8 == 0);
static_assert((sizeof(FirstAxis) + sizeof(FurtherAxis)) % 8 == sizeof(FirstAxis) % 8);
static_assert(kEncapsulation + sizeof(FirstAxis) == kAxisStatusSize);

/// Straight to its place: a copy of what was just written in small pieces would have to wait.
template <typename Layout>
void put_axis(const AxisStatus& status, const AxisAddress& address, std::uint64_t tick,
              const Ownership& owner, std::byte* place) noexcept {
  const auto put = [place](std::size_t offset, const auto& value) {
    std::memcpy(place + offset, &value, sizeof value);
  };
  put(offsetof(Layout, bench), address.bench);
  put(offsetof(Layout, axis), address.axis);
  put(offsetof(Layout, gap_before_tick), decltype(Layout::gap_before_tick){});
  put(offsetof(Layout, tick), tick);
  put(offsetof(Layout, owner_session), owner.session);
  put(offsetof(Layout, owner_epoch), owner.epoch);
  put(offsetof(Layout, gap_before_last_sequence), std::uint32_t{0});
  put(offsetof(Layout, last_sequence), owner.last_sequence);
  put(offsetof(Layout, ds402_statusword), status.ds402_statusword);
  put(offsetof(Layout, op_mode_actual), status.op_mode_actual);
  put(offsetof(Layout, motor_op_status), status.motor_op_status);
  put(offsetof(Layout, error_code), status.error_code);
  put(offsetof(Layout, error_register), status.error_register);
  put(offsetof(Layout, digital_inputs), status.digital_inputs);
  std::memcpy(place + offsetof(Layout, motion), bytes_of(status).data() + kMotion, sizeof(Motion));
  put(offsetof(Layout, current_actual_value), status.current_actual_value);
  put(offsetof(Layout, gap_before_current_error_value), std::uint16_t{0});
  put(offsetof(Layout, current_error_value), status.current_error_value);
  put(offsetof(Layout, torque_demand), status.torque_demand);
  put(offsetof(Layout, torque_actual_value), status.torque_actual_value);
  put(offsetof(Layout, ignored_set_points), status.ignored_set_points);
  put(offsetof(Layout, fault_count), status.fault_count);
}

template <typename Layout>
ReceivedStatus axis_at(const std::byte* place) noexcept {
  Layout axis{};
  std::memcpy(&axis, place, sizeof axis);
  ReceivedStatus received{.address = {.bench = axis.bench, .axis = axis.axis},
                          .tick = axis.tick,
                          .owner = {.session = axis.owner_session,
                                    .epoch = axis.owner_epoch,
                                    .last_sequence = axis.last_sequence},
                          .status = {.current_error_value = axis.current_error_value,
                                     .current_actual_value = axis.current_actual_value,
                                     .torque_actual_value = axis.torque_actual_value,
                                     .torque_demand = axis.torque_demand,
                                     .ds402_statusword = axis.ds402_statusword,
                                     .error_code = axis.error_code,
                                     .op_mode_actual = axis.op_mode_actual,
                                     .motor_op_status = axis.motor_op_status,
                                     .error_register = axis.error_register,
                                     .digital_inputs = axis.digital_inputs,
                                     .ignored_set_points = axis.ignored_set_points,
                                     .fault_count = axis.fault_count}};
  std::memcpy(std::as_writable_bytes(std::span(&received.status, 1)).data() + kMotion,
              place + offsetof(Layout, motion), sizeof(Motion));
  return received;
}

/// Where an axis begins, behind the first one's beginning.
constexpr std::size_t place_of(std::size_t position) noexcept {
  return position == 0 ? 0 : sizeof(FirstAxis) + (position - 1) * sizeof(FurtherAxis);
}

}  // namespace

std::size_t encoded_status_frame_size(std::size_t axes) noexcept {
  return kEncapsulation + sizeof(FrameLayout) + place_of(axes);
}

std::size_t encode_status_frame(const StatusFrameHead& head, const AxesAfterTick& axes,
                                std::span<std::byte> output) noexcept {
  const std::size_t count = axes.status.size();
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
  std::uint16_t number = 0;
  std::memcpy(&number, &axes_[place_of(position) + offsetof(FirstAxis, axis)], sizeof number);
  return number;
}

ReceivedStatus StatusFrameView::axis(std::size_t position) const noexcept {
  const std::byte* const place = &axes_[place_of(position)];
  return position == 0 ? axis_at<FirstAxis>(place) : axis_at<FurtherAxis>(place);
}

}  // namespace vdrive::wire
