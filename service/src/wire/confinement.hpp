// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::service {

/// Whether a process leaves the network interfaces of its machine.
enum class Network : std::uint8_t { leave, keep };

/// Takes from this process, all of its threads and all that they start what an engine never needs:
/// every socket but those of the machine itself (AF_UNIX), other programs, other processes'
/// memory; with `leave`, where the kernel permits, the network interfaces too. Sockets that are
/// open stay usable. What cannot be taken is logged and stays.
void confine_engine(Network network);

/// Likewise for a wire that has joined its domain: no file can be opened, made, moved or removed
/// any more, no program started, and no other process signalled.
void confine_wire();

}  // namespace vdrive::service
