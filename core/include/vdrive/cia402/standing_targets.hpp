// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"

#include <array>

namespace vdrive {

/// The targets that need no edge of bit 4: 6042h in mode 2, 60FFh in 3 and 9, 6071h in 4 and 10. An
/// axis enabled in mode 2, 3 or 4 starts moving to whatever a master has left there (CiA 402-2);
/// with 0 in all of them it stays at rest in every mode. Modes 9 and 10 wait for a new write,
/// positions for an edge or a new set-point.
inline constexpr ObjectAddress kTargetOfVelocityMode{0x6042, 0};
inline constexpr ObjectAddress kTargetVelocity{0x60FF, 0};
inline constexpr ObjectAddress kTargetTorque{0x6071, 0};
inline constexpr std::array kStandingTargets{kTargetOfVelocityMode, kTargetVelocity, kTargetTorque};

}  // namespace vdrive
