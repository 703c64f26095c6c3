// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::service {

/// The pause instruction: this thread waits, and the other thread of the core gets its resources.
inline void relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace vdrive::service
