// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "protocol.hpp"
#include "services.hpp"
#include "vdrive/client/session.hpp"

namespace vdrive::gateway {

/// Answers /freeze: the black box of the bench keeps a window around the present tick.
/// @throws ProtocolError when the request does not name a bench
[[nodiscard]] CallAnswer call_freeze(client::Session& session, const Json& request);

/// Answers /faults: lists the windows that the black box of a bench keeps.
/// @throws ProtocolError when the request is wrong.
[[nodiscard]] CallAnswer call_faults(client::Session& session, const Json& request);

/// Answers /fault: the history that led to the causes of a window, and the samples of an axis in
/// it.
/// @throws ProtocolError when the request is wrong.
[[nodiscard]] CallAnswer call_fault(client::Session& session, const Json& request);

}  // namespace vdrive::gateway
