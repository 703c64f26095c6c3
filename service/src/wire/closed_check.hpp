// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <chrono>

namespace vdrive::service {

/// The self-test of the closed mode: a second participant with the credentials in `settings` must
/// match `participant`; a stranger without credentials, on the same interfaces, must not: neither
/// may receive from the other. `participant` must already publish and subscribe to bench_state.
/// Takes some 0.2 s.
/// @throws wire::NetworkError if the bench would be open, or if even permitted participants do not
///         find it
void check_closed(wire::Participant& participant, const wire::NetworkSettings& settings);

}  // namespace vdrive::service
