// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "axes_call.hpp"
#include "wakeup.hpp"

#include <cstdint>
#include <string_view>

namespace vdrive::client {

inline constexpr std::string_view kTargetReached = "target reached, bit 10";

/// @return 6040h of the only axis of the call, as it is in force.
[[nodiscard]] Result<std::uint16_t> controlword_of(AxesCall& call);

/// Bit 10 also shows that an axis which was halted, by this session or another one, stands still:
/// 6040h tells which it is.
/// @return failed when the axis is halted.
Outcome check_halt(AxesCall& call);

/// Waits until the axis is at its target.
/// @return failed also when it was halted on the way, and when the wait was interrupted: then it
///         goes on.
Outcome await_target(AxesCall& call, const Wakeup& wakeup);

}  // namespace vdrive::client
