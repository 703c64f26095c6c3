// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/outcome.hpp"

namespace vdrive::tool {

/// Halts an axis whose command an interrupt has ended, and says on standard error what became of
/// it.
void halt_after_interrupt(client::Axis& axis, const CommandContext& context);

/// For a velocity or a torque that was commanded and not reached: it has no end, and after its
/// session only the watchdog of the bench would stop the axis, with fault 8130h. Halts the axis
/// after an interrupt, and after a failure that ends the session (see
/// CommandContext::outlives_failures). An interrupt is said on standard error.
/// @return the outcome of the command; after a failure with what became of the axis
[[nodiscard]] client::Outcome end_endless_motion(client::Axis& axis, client::Outcome outcome,
                                                 CommandContext& context);

}  // namespace vdrive::tool
