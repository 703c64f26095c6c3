// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_limits.hpp"

#include <array>
#include <cstddef>

namespace vdrive::ros2 {

inline constexpr std::size_t kCoefficients = 6;

/// A polynomial of the fifth degree at most: coefficients of the rising powers of the time.
using Polynomial = std::array<double, kCoefficients>;

/// The lowest and the highest value of a polynomial within a time, and when.
struct Extremes {
  double low = 0.0;
  double low_time = 0.0;
  double high = 0.0;
  double high_time = 0.0;
};

/// @return the polynomial that goes from one motion to the other in `length` [s]: the cubic one has
///         their positions and velocities, the quintic one their accelerations too.
[[nodiscard]] Polynomial cubic(const JointMotion& from, const JointMotion& to,
                               double length) noexcept;
[[nodiscard]] Polynomial quintic(const JointMotion& from, const JointMotion& to,
                                 double length) noexcept;

[[nodiscard]] double value(const Polynomial& polynomial, double time) noexcept;
[[nodiscard]] Polynomial derivative(const Polynomial& polynomial) noexcept;

/// @return the extremes within [0, length].
[[nodiscard]] Extremes extremes(const Polynomial& polynomial, double length) noexcept;

/// Times and positions of a message may be any numbers.
/// @return whether every sum of the polynomial within [0, length] stays far below the largest
///         double.
[[nodiscard]] bool is_calculable(const Polynomial& polynomial, double length) noexcept;

}  // namespace vdrive::ros2
