// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/axis_track.hpp"
#include "judge/exceptions.hpp"
#include "judge/record.hpp"
#include "vdrive/axis_status.hpp"

#include <array>
#include <cstdint>

/// Common properties of the records of a bench, whether they come from a journal or from a running
/// bench.
namespace vdrive::judge {

/// The objects whose values the rules compare with. An axis of a bench has them from its start.
inline constexpr std::array kKnownFromTheStart{
    objects::kControlword,       objects::kTarget,     objects::kShutdownOption,
    objects::kFollowingWindow,   objects::kMaxTorque,  objects::kLowerLimit,
    objects::kUpperLimit,        objects::kSpeedLimit, objects::kProfileVelocity,
    objects::kCyclePeriod,       objects::kCycleIndex, objects::kMotorSpeedLimit,
    objects::kAccelerationLimit,
};

/// @return whether it is a test-bench input (5E00h and others): a program that writes only these is
///         not a master.
[[nodiscard]] bool is_test_input(ObjectAddress object);

/// @return the state that an axis shows in each tick.
[[nodiscard]] Shown shown_by(const AxisStatus& status) noexcept;

/// @return the display names of the axes of a bench, such as "axis 7.1".
[[nodiscard]] AxisName axes_of_bench(std::uint32_t bench);

}  // namespace vdrive::judge
