// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::service {

/// Whether a process gives up the network interfaces of its machine.
enum class Network : std::uint8_t { leave, keep };

/// Takes away from this process, its threads and its children what an engine never needs: to open
/// sockets other than AF_UNIX, to start programs, to access the memory of other processes; with
/// `leave`, if the kernel permits it, also the network interfaces. Open sockets stay usable. If a
/// right cannot be taken away, this is logged and the right remains.
void confine_engine(Network network);

/// The same for a wire that has joined its domain: from then on it cannot open, create, move or
/// remove files, start programs, or signal other processes.
void confine_wire();

}  // namespace vdrive::service
