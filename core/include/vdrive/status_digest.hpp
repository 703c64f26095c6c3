// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive {

/// Check values over the status images of a bank, the same on every machine. The axes are divided
/// into rows. If one member of one axis differs, `image` and the member's entry in `members` always
/// change; the check value of the axis's row changes too, except in one of 2^32 cases. Member and
/// row together locate the difference.
struct StatusDigest {
  std::uint64_t image = 0;                              ///< over everything, in axis order
  std::array<std::uint32_t, kStatusMembers> members{};  ///< each over all axes

  friend bool operator==(const StatusDigest&, const StatusDigest&) = default;
};

/// @param axes_per_row number of consecutive axes in a row, at least 1
/// @param rows receives the check value of each row; rows beyond its end are left out
[[nodiscard]] StatusDigest digest_of(std::span<const AxisStatus> statuses, std::size_t axes_per_row,
                                     std::span<std::uint32_t> rows) noexcept;

}  // namespace vdrive
