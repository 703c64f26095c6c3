// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

namespace vdrive {

/// Nearest integer, ties to even, in the default rounding mode; |x| < 2⁵¹.
[[nodiscard]] inline double nearest(double x) noexcept {
  constexpr double kRounder = 6755399441055744.0;  // 1.5·2⁵²
  return (x + kRounder) - kRounder;
}

/// Largest integer not above x; |x| < 2⁵¹.
[[nodiscard]] inline double floor_of(double x) noexcept {
  const double rounded = nearest(x);
  return rounded > x ? rounded - 1.0 : rounded;
}

/// Nearest integer modulo 2³², as in a 32-bit register; |x| < 2⁵¹. The low half of the mantissa of
/// the rounded sum is the two's complement of the integer.
[[nodiscard]] inline std::int32_t wrapped(double x) noexcept {
  constexpr double kRounder = 6755399441055744.0;
  return static_cast<std::int32_t>(
      static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(x + kRounder)));
}

/// Nearest integer, saturated to the 32-bit range.
[[nodiscard]] inline std::int32_t saturated(double x) noexcept {
  const double below = x > 2147483647.0 ? 2147483647.0 : x;
  return wrapped(below < -2147483648.0 ? -2147483648.0 : below);
}

/// Nearest integer, saturated to the 16-bit range.
[[nodiscard]] inline double rounded16(double x) noexcept {
  const double below = x > 32767.0 ? 32767.0 : x;
  return nearest(below < -32768.0 ? -32768.0 : below);
}

}  // namespace vdrive
