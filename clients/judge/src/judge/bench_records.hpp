// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/axis_track.hpp"
#include "judge/exceptions.hpp"
#include "judge/record.hpp"
#include "vdrive/axis_status.hpp"

#include <array>
#include <cstdint>

/// What the records of a bench have in common, whether they come from a journal or from a bench
/// that runs.
namespace vdrive::judge {

/// What rules compare with. An axis of a bench has it from its start.
inline constexpr std::array kKnownFromTheStart{
    objects::kControlword,       objects::kTarget,     objects::kShutdownOption,
    objects::kFollowingWindow,   objects::kMaxTorque,  objects::kLowerLimit,
    objects::kUpperLimit,        objects::kSpeedLimit, objects::kProfileVelocity,
    objects::kCyclePeriod,       objects::kCycleIndex, objects::kMotorSpeedLimit,
    objects::kAccelerationLimit,
};

/// @return whether it is an input of the test bench (5E00h and others): whoever writes it is no
/// master.
[[nodiscard]] bool is_test_input(ObjectAddress object);

/// @return what an axis shows in each tick.
[[nodiscard]] Shown shown_by(const AxisStatus& status) noexcept;

/// @return what people call the axes of a bench, such as "axis 7.1".
[[nodiscard]] AxisName axes_of_bench(std::uint32_t bench);

}  // namespace vdrive::judge
