// SPDX-License-Identifier: Apache-2.0
#include "vdrive/assert.hpp"

#include "vdrive/worked_for.hpp"

// The standard assert reports what broke and where on standard error; the core itself prints
// nothing. It must work in optimised builds too.
#undef NDEBUG
#include <cassert>

namespace vdrive {

void abort_broken_invariant(const char* invariant, const char* file, unsigned line) noexcept {
  __assert_fail(invariant, file, line, &worked_for == nullptr ? "vdrive" : worked_for());
}

}  // namespace vdrive
