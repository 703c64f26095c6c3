// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive {

/// Returns what the calling thread is working for, such as "bench 3", for the message of a broken
/// invariant (vdrive/assert.hpp). The core does not know this, so another part of the program may
/// define this function; if none does, the message says "vdrive".
[[gnu::weak]] const char* worked_for() noexcept;

}  // namespace vdrive
