// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"

#include <chrono>

namespace vdrive::service {

/// The self-test of the closed mode: a second participant with the material of `settings` finds
/// `participant`, and a stranger without material, on the same interfaces, does not: neither
/// receives from the other. `participant` publishes and subscribes to bench_state already. Takes
/// some 0.2 s.
/// @throws wire::NetworkError when the bench would be open, or when those who are permitted do not
///         find it either
void check_closed(wire::Participant& participant, const wire::NetworkSettings& settings);

}  // namespace vdrive::service
