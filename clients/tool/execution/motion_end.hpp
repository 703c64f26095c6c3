// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/outcome.hpp"

namespace vdrive::tool {

/// Halts an axis whose command was interrupted, and prints the result on standard error.
void halt_after_interrupt(client::Axis& axis, const CommandContext& context);

/// Ends the motion of a velocity or torque command that did not reach its target. Such a motion
/// does not end by itself: after the session, only the watchdog of the bench would stop the axis,
/// with fault 8130h. So this halts the axis after an interrupt, and after a failure that ends the
/// session (see CommandContext::outlives_failures). An interrupt is reported on standard error.
/// @return the outcome of the command; for a failure, with the result of the halt
[[nodiscard]] client::Outcome end_endless_motion(client::Axis& axis, client::Outcome outcome,
                                                 CommandContext& context);

}  // namespace vdrive::tool
