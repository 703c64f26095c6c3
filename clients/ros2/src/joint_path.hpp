// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_limits.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::ros2 {

inline constexpr std::size_t kCoefficients = 6;

/// A polynomial of at most the fifth degree: coefficients of rising powers of time.
using Polynomial = std::array<double, kCoefficients>;

/// The lowest and the highest value of a polynomial in an interval, and their times.
struct Extremes {
  double low = 0.0;
  double low_time = 0.0;
  double high = 0.0;
  double high_time = 0.0;
};

/// @return the polynomial that leads from one motion to another in `length` [s]: the cubic one
///         matches their positions and velocities, the quintic one also their accelerations.
[[nodiscard]] Polynomial cubic(const JointMotion& from, const JointMotion& to,
                               double length) noexcept;
[[nodiscard]] Polynomial quintic(const JointMotion& from, const JointMotion& to,
                                 double length) noexcept;

[[nodiscard]] double value(const Polynomial& polynomial, double time) noexcept;
[[nodiscard]] Polynomial derivative(const Polynomial& polynomial) noexcept;

/// @return the extremes within [0, length].
[[nodiscard]] Extremes extremes(const Polynomial& polynomial, double length) noexcept;

/// Times and positions in a message may be any numbers.
/// @return whether the sizes of all terms within [0, length], added up, stay far below the largest
///         double, so that no computation with the polynomial overflows.
[[nodiscard]] bool is_calculable(const Polynomial& polynomial, double length) noexcept;

/// A point of a trajectory for one joint.
struct PathPoint {
  double time = 0.0;  ///< [s] since the start of the path
  double position = 0.0;
  std::optional<double> velocity{};
  std::optional<double> acceleration{};
};

/// The path of one joint through the points of a trajectory. Between two points that both have
/// velocity and acceleration it is a quintic polynomial, between two that both have a velocity a
/// cubic one, otherwise a straight line, as in joint_trajectory_controller. A path of straight
/// lines that starts in motion begins with a cubic that ends with the speed of the next line.
class JointPath {
 public:
  /// @param start motion of the joint at time 0
  /// @param points at least one; with increasing times, the first above 0
  JointPath(const JointMotion& start, std::span<const PathPoint> points);

  /// @param time [s] since the start
  /// @return the motion at that time: before the start, the motion at the start; after the end,
  ///         rest at the last point.
  [[nodiscard]] JointMotion at(double time) const noexcept;

  /// The duration [s].
  [[nodiscard]] double duration() const noexcept { return pieces_.back().end; }

  /// Checks the extremes of every piece. A joint that starts beyond a position limit may return.
  /// @return the first limit that the path would violate, such as "velocity 12 rad/s at 0.25 s is
  ///         beyond the limit 10 rad/s"; nothing if it keeps all of them.
  /// @param unit "rad" or "m"
  [[nodiscard]] std::optional<std::string> check(const JointLimits& limits,
                                                 const std::string& unit) const;

 private:
  struct Piece {
    double begin = 0.0;  ///< [s]
    double end = 0.0;
    Polynomial position{};  ///< over the time since the start of the piece
  };

  [[nodiscard]] std::optional<std::string> check_position(const Piece& piece,
                                                          const JointLimits& limits,
                                                          const std::string& unit) const;
  [[nodiscard]] static std::optional<std::string> check_size(const char* what,
                                                             const Polynomial& polynomial,
                                                             const Piece& piece, double limit,
                                                             const std::string& unit);
  void add(const PathPoint& from, const PathPoint& to, const PathPoint* next);

  std::vector<Piece> pieces_;
};

}  // namespace vdrive::ros2
