// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive {

/// Check values over the status images of a bank, the same on every machine. One member of one axis
/// that differs always changes `image` and its entry of `members`, and all but once in 2^32 times
/// its row: together those two name the place.
struct StatusDigest {
  std::uint64_t image = 0;                              ///< over everything, in axis order
  std::array<std::uint32_t, kStatusMembers> members{};  ///< each over all axes

  friend bool operator==(const StatusDigest&, const StatusDigest&) = default;
};

/// @param axes_per_row at least 1
/// @param rows is filled with one check value for each `axes_per_row` axes; those beyond its end
///        are left out
[[nodiscard]] StatusDigest digest_of(std::span<const AxisStatus> statuses, std::size_t axes_per_row,
                                     std::span<std::uint32_t> rows) noexcept;

}  // namespace vdrive
