// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/unit.hpp"

#include <cstdint>
#include <limits>

/// An axis as a joint: rad, rad/s and N.m for a rotary axis, m, m/s and N for a linear one.
namespace vdrive::bridge {

/// Conversion factors from the user units of an axis.
struct JointScale {
  double si_per_user_unit = 1.0;  ///< [rad or m] per user unit: si_per_user_unit()
  /// [N.m or N] per 1 ‰ of the rated torque: effort_per_mille(). NaN until the rating is known.
  double effort_per_mille = std::numeric_limits<double>::quiet_NaN();
};

/// Position, velocity and effort of a joint, measured at the load.
struct JointValues {
  double position = 0.0;  ///< [rad or m]
  double velocity = 0.0;  ///< [rad/s or m/s]
  double effort = 0.0;    ///< [N.m or N]; NaN without an effort_per_mille
};

[[nodiscard]] JointValues joint_values(const AxisStatus& status, const JointScale& scale);

/// @return the size of a user unit: [rad] for a rotary axis, [m] for a linear one; in its own unit
///         for a linear axis whose unit is not a length.
[[nodiscard]] double si_per_user_unit(const Unit& unit);

/// The parameters of a drive that relate 6077h to the load.
struct TorqueRating {
  std::int64_t motor_rated_torque = 0;      ///< 6076h [mN.m]
  std::int64_t gear_ratio_numerator = 1;    ///< 3576h [load revolutions]
  std::int64_t gear_ratio_denominator = 1;  ///< 3577h [motor revolutions]
};

/// @return 1 ‰ of the rated torque, referred to the place where 6064h is measured, without
///         friction: [N.m] for a rotary axis, [N] for a linear one.
[[nodiscard]] double effort_per_mille(const Unit& unit, const TorqueRating& rating);

}  // namespace vdrive::bridge
