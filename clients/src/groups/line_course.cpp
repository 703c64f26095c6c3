// SPDX-License-Identifier: Apache-2.0
#include "groups/line_course.hpp"

#include "calls/axes_call.hpp"
#include "vdrive/quantity.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::client {
namespace {

// The rounding of targets to integers takes them off a line by at most this much [UU].
constexpr double kTargetRounding = 1.0;

// Demand positions may be further off: each is rounded, the axes may have started half a unit from
// their origin, and the course may have changed by the rounding of its target [UU].
constexpr double kDemandRounding = 3.0;

/// The positions of the axes along a course, as fractions of the longest distance.
class Measure {
 public:
  explicit Measure(const LineCourse& course) : course_(course) {
    for (std::size_t place = 1; place < course.origin.size(); ++place) {
      if (std::abs(way(place)) > std::abs(way(longest_))) longest_ = place;
    }
  }

  /// @return the distance [UU] of the axis at `place`.
  [[nodiscard]] double way(std::size_t place) const {
    return static_cast<double>(course_.farthest[place]) - course_.origin[place];
  }

  [[nodiscard]] std::size_t longest() const { return longest_; }

  /// @return the fraction of its distance that the axis with the longest distance has covered at
  ///         `position` [UU].
  [[nodiscard]] double share(double position) const {
    return of_way(position - course_.origin[longest_]);
  }

  /// @return `value` of the axis with the longest distance, as a fraction of that distance.
  [[nodiscard]] double of_way(double value) const {
    const double measure = way(longest_);
    return measure == 0.0 ? 0.0 : value / measure;
  }

  /// @return the position of the axis at `place` at this fraction of its distance [UU].
  [[nodiscard]] double position(std::size_t place, double share) const {
    return course_.origin[place] + share * way(place);
  }

 private:
  const LineCourse& course_;
  std::size_t longest_ = 0;
};

/// The value of an axis, and the corresponding value on the line.
struct OnLine {
  std::string_view what;  ///< name and object
  Dimension dimension = Dimension::position;
  std::int32_t value = 0;
  double of_line = 0.0;
  double rounding = 0.0;  ///< tolerance
};

Outcome check_on_line(const AxisId& axis, const Unit& unit, const OnLine& seen) {
  constexpr double kNoise = 1.0e-6;  // of the computation
  if (std::abs(seen.value - seen.of_line) <= seen.rounding + kNoise) return {};
  const auto text = [&](double value) {
    return quantity_text(std::llround(value), seen.dimension, unit);
  };
  return not_in_this_state("axis " + to_string(axis) + ": its " + std::string(seen.what) + " is " +
                           text(seen.value) + ", but the present line needs " + text(seen.of_line) +
                           ", give or take " + text(std::floor(seen.rounding)) +
                           ": a line starts from rest or continues the present one");
}

Outcome check_motion(const Measure& measure, std::span<const AxisSnapshot> axes,
                     std::span<const Unit> units) {
  const AxisStatus& first = axes[measure.longest()].status;
  const double share = measure.share(first.position_demand_value);
  const double speed = measure.of_way(first.velocity_demand_value);  // [1/s]
  for (std::size_t place = 0; place < axes.size(); ++place) {
    const AxisStatus& status = axes[place].status;
    Outcome velocity = check_on_line(axes[place].id, units[place],
                                     {.what = "velocity demand (606Bh)",
                                      .dimension = Dimension::velocity,
                                      .value = status.velocity_demand_value,
                                      .of_line = speed * measure.way(place),
                                      .rounding = 1.0 + kDemandRounding * std::abs(speed)});
    if (!velocity) return velocity;
    Outcome position = check_on_line(axes[place].id, units[place],
                                     {.what = "position demand (6062h)",
                                      .value = status.position_demand_value,
                                      .of_line = measure.position(place, share),
                                      .rounding = kDemandRounding});
    if (!position) return position;
  }
  return {};
}

/// Beyond its farthest target a line is known less exactly, because that target is rounded.
Outcome check_targets(const Measure& measure, std::span<const AxisSnapshot> axes,
                      std::span<const std::int32_t> targets, std::span<const Unit> units) {
  const double share = measure.share(targets[measure.longest()]);
  for (std::size_t place = 0; place < axes.size(); ++place) {
    Outcome target = check_on_line(axes[place].id, units[place],
                                   {.what = "target (607Ah)",
                                    .value = targets[place],
                                    .of_line = measure.position(place, share),
                                    .rounding = kTargetRounding * std::max(1.0, std::abs(share))});
    if (!target) return target;
  }
  return {};
}

}  // namespace

bool is_on_the_move(std::span<const AxisSnapshot> axes) noexcept {
  return std::ranges::any_of(axes, [](const AxisSnapshot& axis) {
    return axis.status.velocity_demand_value != 0;
  });
}

Result<LineCourse> continued_course(const std::optional<LineCourse>& present_course,
                                    std::span<const AxisSnapshot> axes,
                                    std::span<const std::int32_t> targets,
                                    std::span<const Unit> units) {
  if (!present_course) {
    const auto moving = std::ranges::find_if(axes, [](const AxisSnapshot& axis) {
      return axis.status.velocity_demand_value != 0;
    });
    return not_in_this_state(
        "axis " + to_string(moving->id) + " is still moving: its velocity demand (606Bh) is " +
        quantity_text(moving->status.velocity_demand_value, Dimension::velocity,
                      units[static_cast<std::size_t>(moving - axes.begin())]) +
        ", but must be 0 since this group has no line to continue");
  }
  const Measure measure(*present_course);
  if (Outcome moves = check_motion(measure, axes, units); !moves) return moves;
  if (Outcome leads = check_targets(measure, axes, targets, units); !leads) return leads;
  LineCourse course = *present_course;
  if (std::abs(measure.share(targets[measure.longest()])) > 1.0) {
    course.farthest.assign(targets.begin(), targets.end());
  }
  return course;
}

std::vector<double> ways_along(const LineCourse& course) {
  const Measure measure(course);
  std::vector<double> ways;
  for (std::size_t place = 0; place < course.origin.size(); ++place) {
    // An axis that does not move along the line gets a reference way of 1: with 5E10h:05 = 0 its
    // drive would demand a start from rest.
    ways.push_back(std::max(1.0, std::abs(measure.way(place))));
  }
  return ways;
}

}  // namespace vdrive::client
