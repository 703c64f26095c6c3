// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

namespace vdrive::client {

// The objects that tests of the client read and write.
inline constexpr ObjectAddress kControlword{0x6040, 0};
inline constexpr ObjectAddress kMode{0x6060, 0};
inline constexpr ObjectAddress kTarget{0x607A, 0};
inline constexpr ObjectAddress kTargetVelocity{0x60FF, 0};
inline constexpr ObjectAddress kVelocity{0x6081, 0};
inline constexpr ObjectAddress kAcceleration{0x6083, 0};
inline constexpr ObjectAddress kDeceleration{0x6084, 0};
inline constexpr ObjectAddress kSpeedLimit{0x607F, 0};
inline constexpr ObjectAddress kMotorSpeed{0x6080, 0};
inline constexpr ObjectAddress kLimitSwitch{0x3535, 0};
inline constexpr ObjectAddress kLowerLimit{0x607D, 1};
inline constexpr ObjectAddress kUpperLimit{0x607D, 2};
inline constexpr ObjectAddress kPositioningOption{0x60F2, 0};
inline constexpr ObjectAddress kMaxTorque{0x6072, 0};
inline constexpr ObjectAddress kRatedCurrent{0x6075, 0};
inline constexpr ObjectAddress kPositiveTorqueLimit{0x60E0, 0};
inline constexpr ObjectAddress kNegativeTorqueLimit{0x60E1, 0};
inline constexpr ObjectAddress kWindow{0x6067, 0};
inline constexpr ObjectAddress kDemand{0x6062, 0};
inline constexpr ObjectAddress kTorqueDemand{0x6074, 0};
inline constexpr ObjectAddress kBlockedLoad{0x5E01, 0};
inline constexpr ObjectAddress kOverCurrent{0x5E02, 0};
inline constexpr ObjectAddress kPositiveLimit{0x5E06, 0};
inline constexpr ObjectAddress kMoveDuration{0x5E10, 1};
inline constexpr ObjectAddress kMoveJerkTime{0x5E10, 4};
inline constexpr ObjectAddress kMoveReferenceWay{0x5E10, 5};
inline constexpr ObjectAddress kProfileType{0x6086, 0};

inline constexpr auto kRefusedInState = wire_code(AbortCode::refused_in_present_device_state);

}  // namespace vdrive::client
