// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

// Hot loops are plain loops over the lanes of a block, which the compiler vectorises for each
// instruction set. To give the same bits for every width they use only + - * / and comparisons, no
// contraction and no sum across lanes.

// Builds with sanitizers have no clones: the loader resolves them before the runtime of the
// sanitizer is ready.
#if defined(__x86_64__) && !defined(VDRIVE_NO_TARGET_CLONES)
#define VDRIVE_VECTOR_CLONES \
  __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define VDRIVE_VECTOR_CLONES
#endif

#if defined(VDRIVE_NO_TARGET_CLONES)
#define VDRIVE_INDEPENDENT_LANES
#elif defined(__clang__)
#define VDRIVE_INDEPENDENT_LANES _Pragma("clang loop vectorize(assume_safety)")
#else
#define VDRIVE_INDEPENDENT_LANES _Pragma("GCC ivdep")
#endif

namespace vdrive {

/// Number of axes computed together.
inline constexpr std::size_t kLanes = 8;

/// One double per axis of a block.
using Lane = std::array<double, kLanes>;

}  // namespace vdrive
