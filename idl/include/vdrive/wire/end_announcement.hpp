// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/source.hpp"

namespace vdrive::wire {

/// Announces the end of a participant that died without leaving, such as a network process that was
/// killed: other participants remove it at once, not when its lease ends. Sends a few datagrams to
/// the addresses where a participant with these settings would announce itself; waits for no
/// answer. Sends nothing to discovery servers: they accept this from the participant itself only,
/// and remove it after its lease of 2 s. The datagrams are not encrypted, in the closed mode
/// neither, as announcements are not.
/// @throws NetworkError when no socket can be made
void announce_end(const NetworkSettings& settings, const Source& dead);

}  // namespace vdrive::wire
