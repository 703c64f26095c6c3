// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::service {

/// @param file an open descriptor of a file whose lock (flock) somebody else has
/// @return who has it, such as "process 4711 (vdrived) of this host", by /proc/locks: that lists no
///         process of another host or container, and no file of some file systems; then the text
///         says so.
[[nodiscard]] std::string holder_of_lock(int file);

}  // namespace vdrive::service
