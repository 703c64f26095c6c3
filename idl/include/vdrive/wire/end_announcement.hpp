// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/source.hpp"

namespace vdrive::wire {

/// Announces the end of a participant that died without announcing it, such as a network process
/// that was killed: other participants then remove it immediately instead of when its lease ends.
/// Sends a few datagrams to the addresses where a participant with these settings would announce
/// itself, and waits for no answer. Sends nothing to discovery servers, which accept this only from
/// the participant itself and remove it after its lease of 2 s. Like announcements, these datagrams
/// are not encrypted, not even in the closed mode.
/// @throws NetworkError when no socket can be opened
void announce_end(const NetworkSettings& settings, const Source& dead);

}  // namespace vdrive::wire
