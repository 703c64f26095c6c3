// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::service {

/// Takes the lock (flock) of an open file for this process. All processes that have the file open
/// by the same descriptor have its lock: one that is forked from this one closes its copy at once,
/// so that the lock ends with this process, however that ends.
/// @return false when somebody else has it; @throws std::system_error
[[nodiscard]] bool try_lock_file(int file);

/// Closes a file, and gives back its lock where it has one.
/// @return what close() returns
int unlock_and_close(int file) noexcept;

/// @param file an open descriptor of a file whose lock (flock) somebody else has
/// @return who has it, such as "process 4711 (vdrived) of this host", by /proc/locks: that lists no
///         process of another host or container, and no file of some file systems; then the text
///         says so.
[[nodiscard]] std::string holder_of_lock(int file);

}  // namespace vdrive::service
