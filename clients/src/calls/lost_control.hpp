// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/session_core.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/client/outcome.hpp"

#include <span>

namespace vdrive::client {

/// For a call that has ended. A command frame with an epoch that is not current is refused, and its
/// answer does not say who has taken the axes: their status does. Waits for that status, and for
/// the name of the new owner, a second at most in all where the bench sends.
/// @param axes that the call has commanded
/// @return a refusal for that reason, with the session that holds one of the axes now, where one
///         does; any other outcome as it is.
[[nodiscard]] Outcome explain_loss(SessionCore& core, Outcome outcome,
                                   std::span<const AxisId> axes);

/// The same for a call with an outcome for each axis.
void explain_losses(SessionCore& core, std::span<Outcome> outcomes, std::span<const AxisId> axes);

}  // namespace vdrive::client
