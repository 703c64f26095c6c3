// SPDX-License-Identifier: Apache-2.0
#include "joint_path.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdrive::ros2 {
namespace {

// Rounding tolerance relative to a limit: a program that plans exactly up to the limit must not be
// refused.
constexpr double kRoom = 1e-9;

/// @return the text about a violated limit.
std::string broken(const char* what, double value, const std::string& unit, double time,
                   double limit) {
  return std::string(what) + " " + text_of(value) + " " + unit + " at " + text_of(time) +
         " s is beyond the limit " + text_of(limit) + " " + unit;
}

/// Also true if the computation gave NaN.
bool is_above(double value, double limit) noexcept {
  return !(value <= limit + kRoom * std::max(1.0, std::abs(limit)));
}

}  // namespace

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
  // The derivative of a quintic has up to four zeros. Two in the same part are missed: the value
  // between them hardly differs from the values at the ends of the part.
  constexpr int kParts = 64;
  constexpr int kHalvings = 50;  // 2^-50 of a part is below the rounding error of a time
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
  // Far from 1.8e308, so that the coefficients of the derivatives, up to 20 times as large, stay
  // finite.
  constexpr double kLargest = 1e200;
  Polynomial sizes{};
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = std::abs(polynomial[i]);
  const double longest = std::max(1.0, length);
  return value(sizes, longest) < kLargest;
}

std::string text_of(double value) {
  constexpr int kDigits = 6;
  std::ostringstream text;
  text.precision(kDigits);
  text << value;
  return text.str();
}

JointPath::JointPath(const JointMotion& start, std::span<const PathPoint> points) {
  ensure(!points.empty(), "a path has a point, where it ends");
  pieces_.reserve(points.size());
  PathPoint from{.time = 0.0,
                 .position = start.position,
                 .velocity = start.velocity,
                 .acceleration = start.acceleration};
  for (std::size_t i = 0; i < points.size(); ++i) {
    add(from, points[i], i + 1 < points.size() ? &points[i + 1] : nullptr);
    from = points[i];
  }
}

void JointPath::add(const PathPoint& from, const PathPoint& to, const PathPoint* next) {
  const double length = to.time - from.time;
  JointMotion begin{from.position, from.velocity.value_or(0.0), from.acceleration.value_or(0.0)};
  JointMotion end{to.position, to.velocity.value_or(0.0), to.acceleration.value_or(0.0)};
  Piece piece{.begin = from.time, .end = to.time};
  if (from.velocity && to.velocity && from.acceleration && to.acceleration) {
    piece.position = quintic(begin, end, length);
  } else if (from.velocity && to.velocity) {
    piece.position = cubic(begin, end, length);
  } else if (begin.velocity != 0.0 && pieces_.empty()) {
    if (next != nullptr) end.velocity = (next->position - to.position) / (next->time - to.time);
    piece.position = cubic(begin, end, length);
  } else {
    piece.position = {from.position, (to.position - from.position) / length};
  }
  pieces_.push_back(piece);
}

JointMotion JointPath::at(double time) const noexcept {
  if (time >= duration()) {
    const Piece& last = pieces_.back();
    return {value(last.position, last.end - last.begin), 0.0, 0.0};
  }
  const auto after = std::ranges::upper_bound(pieces_, time, {}, &Piece::end);
  const double inside = std::max(0.0, time - after->begin);
  const Polynomial speed = derivative(after->position);
  return {value(after->position, inside), value(speed, inside), value(derivative(speed), inside)};
}

std::optional<std::string> JointPath::check_position(const Piece& piece, const JointLimits& limits,
                                                     const std::string& unit) const {
  // A joint beyond a limit may return, but must not go further.
  const double start = value(pieces_.front().position, 0.0);
  const Extremes way = extremes(piece.position, piece.end - piece.begin);
  if (is_above(way.high, std::max(limits.upper, start))) {
    return broken("position", way.high, unit, piece.begin + way.high_time, limits.upper);
  }
  if (is_above(-way.low, -std::min(limits.lower, start))) {
    return broken("position", way.low, unit, piece.begin + way.low_time, limits.lower);
  }
  return std::nullopt;
}

std::optional<std::string> JointPath::check_size(const char* what, const Polynomial& polynomial,
                                                 const Piece& piece, double limit,
                                                 const std::string& unit) {
  const Extremes found = extremes(polynomial, piece.end - piece.begin);
  const bool is_high = found.high >= -found.low;
  const double largest = is_high ? found.high : found.low;
  if (!is_above(std::abs(largest), limit)) return std::nullopt;
  return broken(what, largest, unit, piece.begin + (is_high ? found.high_time : found.low_time),
                limit);
}

std::optional<std::string> JointPath::check(const JointLimits& limits,
                                            const std::string& unit) const {
  for (const Piece& piece : pieces_) {
    if (!is_calculable(piece.position, piece.end - piece.begin)) {
      return "the path to the point at " + text_of(piece.end) + " s is numerically unbounded";
    }
    const Polynomial speed = derivative(piece.position);
    auto problem = check_position(piece, limits, unit);
    if (!problem) problem = check_size("velocity", speed, piece, limits.velocity, unit + "/s");
    if (!problem) {
      problem = check_size("acceleration", derivative(speed), piece,
                           std::min(limits.acceleration, limits.deceleration), unit + "/s²");
    }
    if (problem) return problem;
  }
  return std::nullopt;
}

}  // namespace vdrive::ros2
