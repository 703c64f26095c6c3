// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive_messages_description.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// Samples of StatusFrame and AxisStatus, which a service sends each tick: written and read in one
/// pass, directly between status images and bytes, without a message object.
namespace vdrive::wire {

/// The fields common to all axes of a status frame.
struct StatusFrameHead {
  std::uint32_t bench = 0;
  std::uint32_t skipped_ticks = 0;  ///< jumped over in this run of the bench, modulo 2^32
  std::uint64_t incarnation = 0;
  std::uint64_t tick = 0;
  std::int64_t time_ns = 0;
  std::uint16_t part = 0;
  std::uint16_t parts = 1;
};

/// The axes of a bench after one tick; all three spans have the same length.
struct AxesAfterTick {
  std::span<const AxisStatus> status;
  std::span<const Ownership> owners;
  std::span<const std::uint16_t> numbers;
};

/// @return the size of a sample of StatusFrame with `axes` axes [bytes].
[[nodiscard]] std::size_t encoded_status_frame_size(std::size_t axes) noexcept;

/// Writes a sample of StatusFrame: the bytes that `to_message` and `encode` would give.
/// @return the number of bytes written; 0 if `output` is too short.
std::size_t encode_status_frame(const StatusFrameHead& head, const AxesAfterTick& axes,
                                std::span<std::byte> output) noexcept;

/// Size of a sample of AxisStatus [bytes].
inline constexpr std::size_t kAxisStatusSize = largest_sample<msg::AxisStatus>();

/// Writes a sample of AxisStatus. @return the number of bytes written; 0 if it does not fit.
std::size_t encode_axis_status(const AxisStatus& status, const AxisAddress& address,
                               std::uint64_t tick, const Ownership& owner,
                               std::span<std::byte> output) noexcept;

/// An axis in a received status frame.
struct ReceivedStatus {
  AxisAddress address;
  std::uint64_t tick = 0;
  Ownership owner;
  AxisStatus status;
};

/// A received sample of StatusFrame, read in place: axes that the program does not need cost
/// nothing. Valid as long as these bytes are.
class StatusFrameView {
 public:
  /// @return nothing if the sample is truncated, has more than MAX_AXES_PER_FRAME axes, or is not
  ///         plain CDR in little-endian byte order, which every service writes.
  [[nodiscard]] static std::optional<StatusFrameView> of(
      std::span<const std::byte> sample) noexcept;

  [[nodiscard]] const StatusFrameHead& head() const noexcept { return head_; }

  /// @return the number of axes in the frame.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

  /// @param position below size()
  /// @return the number of that axis on its bench.
  [[nodiscard]] std::uint16_t number(std::size_t position) const noexcept;

  /// @param position below size()
  [[nodiscard]] ReceivedStatus axis(std::size_t position) const noexcept;

 private:
  StatusFrameView() = default;

  StatusFrameHead head_;
  std::size_t size_ = 0;
  std::span<const std::byte> axes_;
};

}  // namespace vdrive::wire
