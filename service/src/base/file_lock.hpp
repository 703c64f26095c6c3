// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::service {

/// Takes the lock (flock) of an open file for this process. A forked process would share the lock
/// through its copy of the descriptor, so it closes its copy immediately: the lock ends with this
/// process, however it ends.
/// @return false if another process holds the lock; @throws std::system_error
[[nodiscard]] bool try_lock_file(int file);

/// Closes a file and releases its lock, if it has one.
/// @return the result of close()
int unlock_and_close(int file) noexcept;

/// @param file an open descriptor of a file whose lock (flock) another process holds
/// @return the holder according to /proc/locks, for example "process 4711 (vdrived) on this host".
///         /proc/locks lists no holder on another host or in another container, and no lock at all
///         on some file systems; the text says so if the holder is not listed.
[[nodiscard]] std::string holder_of_lock(int file);

}  // namespace vdrive::service
