// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive {

/// What the calling thread works for, such as "bench 3", in the message of a broken invariant
/// (vdrive/assert.hpp). The core has no state, so a room that knows defines it; where none does the
/// message says "vdrive".
[[gnu::weak]] const char* worked_for() noexcept;

}  // namespace vdrive
