// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::service {

/// The pause instruction: for spin loops; leaves the core's resources to its other hardware thread.
inline void relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace vdrive::service
