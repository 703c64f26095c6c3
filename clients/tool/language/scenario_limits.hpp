// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace vdrive::tool {

// What a scenario may have at most: a mistake, or a file of another kind, is found before it takes
// memory or time. The largest sensible line names each of some thousand axes.

/// Bytes of a line, with the values in the places of its variables, too.
inline constexpr std::size_t kLongestLine = std::size_t{32} << 10U;

/// Words of a line.
inline constexpr std::size_t kMostWords = 4'096;

/// Bytes of a file, with the values in the places of its variables, too.
inline constexpr std::size_t kLargestScenario = std::size_t{4} << 20U;

}  // namespace vdrive::tool
