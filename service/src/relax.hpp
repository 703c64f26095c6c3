// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::service {

/// Tells the processor that this thread waits: the other thread of a core may go on.
inline void relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace vdrive::service
