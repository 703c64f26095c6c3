// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/outcome.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::client {

/// The course of a straight line: two of its points [UU], in the group's order.
struct LineCourse {
  std::vector<std::int32_t> origin;    ///< where it started from rest
  std::vector<std::int32_t> farthest;  ///< of its targets, the one farthest from the origin
};

/// @return whether 606Bh of any axis is not 0.
[[nodiscard]] bool is_on_the_move(std::span<const AxisSnapshot> axes) noexcept;

/// Determines the course of a line to `targets` [UU] that moving axes can join: their present
/// course, extended if a target lies beyond it.
/// @param present_course the course of their present line; nothing if they move without one
/// @param units of the axes, for messages
/// @return refused, naming the axis, its value and the value on the line, if an axis or its target
///         is off `present_course` by more than the rounding to integers.
[[nodiscard]] Result<LineCourse> continued_course(const std::optional<LineCourse>& present_course,
                                                  std::span<const AxisSnapshot> axes,
                                                  std::span<const std::int32_t> targets,
                                                  std::span<const Unit> units);

/// @return the distances of the axes along `course` [UU], integers of at least 1.
[[nodiscard]] std::vector<double> ways_along(const LineCourse& course);

}  // namespace vdrive::client
