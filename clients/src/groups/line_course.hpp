// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/outcome.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::client {

/// Where a straight line runs: two of its points [UU], in the order of the group.
struct LineCourse {
  std::vector<std::int32_t> origin;    ///< where it began from rest
  std::vector<std::int32_t> farthest;  ///< of its targets the one with the longest way from there
};

/// @return whether 606Bh of any axis is not 0.
[[nodiscard]] bool is_on_the_move(std::span<const AxisSnapshot> axes) noexcept;

/// The course of a line to `targets` [UU] that moving axes can take on their way: the one that they
/// move along, with its farthest target.
/// @param in_hand the course of their line, nothing where they move without one
/// @param units of the axes, for messages
/// @return refused, naming the axis, its value and that of the line, when an axis moves beside
///         `in_hand`, or its target lies beside it, by more than the rounding to whole units.
[[nodiscard]] Result<LineCourse> continued_course(const std::optional<LineCourse>& in_hand,
                                                  std::span<const AxisSnapshot> axes,
                                                  std::span<const std::int32_t> targets,
                                                  std::span<const Unit> units);

/// @return the ways of the axes along `course` [UU], whole and at least 1.
[[nodiscard]] std::vector<double> ways_along(const LineCourse& course);

}  // namespace vdrive::client
