// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::wire {

/// The highest number of a bench; the lowest is 1 (docs/reference/wire.md, identities).
inline constexpr std::uint32_t kHighestBench = 65'535;

}  // namespace vdrive::wire
