// SPDX-License-Identifier: Apache-2.0
#include "polynomial.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive::ros2 {

Polynomial cubic(const JointMotion& from, const JointMotion& to, double length) noexcept {
  const double way = to.position - from.position;
  const double square = length * length;
  return {from.position, from.velocity,
          (3.0 * way - (2.0 * from.velocity + to.velocity) * length) / square,
          (-2.0 * way + (from.velocity + to.velocity) * length) / (square * length)};
}

Polynomial quintic(const JointMotion& from, const JointMotion& to, double length) noexcept {
  const double way = to.position - from.position;
  const double t2 = length * length;
  const double t3 = t2 * length;
  const double v0 = from.velocity * length;
  const double v1 = to.velocity * length;
  const double a0 = from.acceleration * t2;
  const double a1 = to.acceleration * t2;
  return {from.position,
          from.velocity,
          0.5 * from.acceleration,
          (20.0 * way - 8.0 * v1 - 12.0 * v0 - 3.0 * a0 + a1) / (2.0 * t3),
          (-30.0 * way + 14.0 * v1 + 16.0 * v0 + 3.0 * a0 - 2.0 * a1) / (2.0 * t3 * length),
          (12.0 * way - 6.0 * v1 - 6.0 * v0 - a0 + a1) / (2.0 * t3 * t2)};
}

double value(const Polynomial& polynomial, double time) noexcept {
  double sum = 0.0;
  for (std::size_t i = polynomial.size(); i-- > 0;) sum = sum * time + polynomial[i];
  return sum;
}

Polynomial derivative(const Polynomial& polynomial) noexcept {
  Polynomial result{};
  for (std::size_t i = 1; i < polynomial.size(); ++i) {
    result[i - 1] = polynomial[i] * static_cast<double>(i);
  }
  return result;
}

Extremes extremes(const Polynomial& polynomial, double length) noexcept {
  // The slope of a quintic has up to four zeros. Two that lie in one part are not seen: the value
  // between them hardly differs from those at the ends of the part.
  constexpr int kParts = 64;
  constexpr int kHalvings = 50;  // 2^-50 of a part is below the rounding of a time
  Extremes found{value(polynomial, 0.0), 0.0, value(polynomial, 0.0), 0.0};
  const auto take = [&](double time) {
    const double here = value(polynomial, time);
    if (here < found.low) found = {here, time, found.high, found.high_time};
    if (here > found.high) found = {found.low, found.low_time, here, time};
  };
  const Polynomial slope = derivative(polynomial);
  for (int part = 0; part < kParts; ++part) {
    double low = length * part / kParts;
    double high = length * (part + 1) / kParts;
    take(high);
    const bool rises = value(slope, low) > 0.0;
    if (rises == (value(slope, high) > 0.0)) continue;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      ((value(slope, middle) > 0.0) == rises ? low : high) = middle;
    }
    take(low);
  }
  return found;
}

bool is_calculable(const Polynomial& polynomial, double length) noexcept {
  // Far from 1.8e308: also the coefficients of the derivatives, up to 20 times as large, stay
  // numbers.
  constexpr double kLargest = 1e200;
  Polynomial sizes{};
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = std::abs(polynomial[i]);
  const double longest = std::max(1.0, length);
  return value(sizes, longest) < kLargest;
}

}  // namespace vdrive::ros2
