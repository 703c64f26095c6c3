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

/// Samples of Reply, the answer to each step. The axes in it are copied directly between status
/// images and bytes, like those of a status frame.
namespace vdrive::wire {

/// An axis included in a reply.
struct ShownAxis {
  std::uint16_t number = 0;  ///< on its bench
  std::uint64_t tick = 0;    ///< of the status
  Ownership owner;
  AxisStatus status;
};

/// @return the size of a sample of Reply with the objects of `reply` and `axes` axes [bytes].
[[nodiscard]] std::size_t encoded_reply_size(const msg::Reply& reply, std::size_t axes) noexcept;

/// Writes a sample of Reply: the bytes that `encode` would give for `reply` with these axes as its
/// statuses. The statuses in `reply` are ignored.
/// @return the number of bytes written; 0 if `output` is too short.
std::size_t encode_reply(const msg::Reply& reply, std::span<const ShownAxis> axes,
                         std::span<std::byte> output) noexcept;

/// Reads a sample of Reply. Does not allocate once `reply` and `axes` have had their largest size.
/// @param reply receives everything except the statuses
/// @return false if the sample is truncated, is not plain CDR in little-endian byte order, which
///         every service writes, or has a sequence beyond its bound.
[[nodiscard]] bool decode_reply(std::span<const std::byte> sample, msg::Reply& reply,
                                std::vector<ReceivedStatus>& axes);

}  // namespace vdrive::wire
