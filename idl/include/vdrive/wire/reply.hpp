// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/wire/conversion.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Samples of Reply, which answers each step: the axes that it shows are copied between status
/// images and bytes, as those of a status frame are.
namespace vdrive::wire {

/// An axis that a reply shows.
struct ShownAxis {
  std::uint16_t number = 0;  ///< on its bench
  std::uint64_t tick = 0;    ///< of the status
  Ownership owner;
  AxisStatus status;
};

/// @return bytes of a sample of Reply with the objects of `reply` and that many axes.
[[nodiscard]] std::size_t encoded_reply_size(const msg::Reply& reply, std::size_t axes) noexcept;

/// Writes a sample of Reply: the bytes that `encode` would give for `reply` with these axes as its
/// statuses. Its own statuses are left out.
/// @return how many bytes were written; 0 when `output` is too short.
std::size_t encode_reply(const msg::Reply& reply, std::span<const ShownAxis> axes,
                         std::span<std::byte> output) noexcept;

/// Reads a sample of Reply. Allocates nothing once `reply` and `axes` have had their largest size.
/// @param reply gets all but the statuses
/// @return false when the sample ends early, has another encapsulation than plain CDR in
///         little-endian byte order, which every service writes, or a sequence is beyond its bound.
[[nodiscard]] bool decode_reply(std::span<const std::byte> sample, msg::Reply& reply,
                                std::vector<ReceivedStatus>& axes);

}  // namespace vdrive::wire
