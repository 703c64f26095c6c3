// SPDX-License-Identifier: Apache-2.0
#include "vdrive/assert.hpp"

#include "vdrive/worked_for.hpp"

// The failure function of the standard assert prints the invariant and its location to standard
// error, so the core needs no output code. NDEBUG would hide that function in optimised builds.
#undef NDEBUG
#include <cassert>

namespace vdrive {

void abort_broken_invariant(const char* invariant, const char* file, unsigned line) noexcept {
  __assert_fail(invariant, file, line, &worked_for == nullptr ? "vdrive" : worked_for());
}

}  // namespace vdrive
