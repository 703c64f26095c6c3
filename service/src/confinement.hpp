// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::service {

/// Takes from this process, all of its threads and all that they start what an engine never needs:
/// every socket but those of the machine itself (AF_UNIX), other programs, other processes'
/// memory; where the kernel permits, the network interfaces too. Sockets that are open stay
/// usable. What cannot be taken is logged and stays.
void confine_engine();

/// Likewise for a wire that has joined its domain: no file can be opened, made, moved or removed
/// any more, and no program started.
void confine_wire();

}  // namespace vdrive::service
