// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plant/servo_block.hpp"
#include "vdrive/plant/axis_model.hpp"

#include <cstdint>

namespace vdrive {

inline constexpr double kTwoPi = 6.283185307179586476925;  ///< [rad] per revolution

/// User units per radian, for motor and load shaft alike.
inline constexpr double kUserUnitsPerRadian = kUserUnitsPerRevolution / kTwoPi;

/// Gear of 3576h/3577h: load velocity = motor velocity x numerator / denominator.
struct Gear {
  std::uint32_t numerator = 1;
  std::uint32_t denominator = 1;
};

/// @return load revolutions per motor revolution.
[[nodiscard]] inline double ratio_of(const Gear& gear) noexcept {
  return static_cast<double>(gear.numerator) / static_cast<double>(gear.denominator);
}

/// Torque limits at the motor shaft [N.m], both >= 0.
struct TorqueLimits {
  double positive = 0.0;
  double negative = 0.0;
};

/// @return the torque at the motor shaft [N.m] that the block writes as 1 UU/s²: the one that gives
///         this acceleration to the motor alone or, on a rigid axis, to motor and load.
[[nodiscard]] double torque_unit(const AxisModel& model, const Gear& gear) noexcept;

/// @return UU/s² of ServoState::load_torque per 1 N.m at the load shaft.
[[nodiscard]] double load_torque_factor(const AxisModel& model, const Gear& gear) noexcept;

/// Discretises model and loops exactly for a sub-step [s] and fills one lane.
void design_lane(const AxisModel& model, const Gear& gear, double substep, std::size_t lane,
                 RigidParameters& parameters);
void design_lane(const AxisModel& model, const Gear& gear, double substep, std::size_t lane,
                 ElasticParameters& parameters);

void limit_lane(const TorqueLimits& limits, double torque_unit, std::size_t lane,
                LoopParameters& loop) noexcept;

}  // namespace vdrive
