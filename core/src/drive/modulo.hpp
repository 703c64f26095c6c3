// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/block.hpp"
#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// What the position range 607Bh means to a modulo axis.

/// Puts the positions of the axis into its range: 6062h and 6064h; with one encoder 3572h, which is
/// 6064h then. With two 3572h counts on, and 3573h is what both show.
void fold_numbers(const Drive& drive, NumberBlock& numbers) noexcept;

/// @param target absolute [UU], by 607Ah
/// @param option 60F2h, as the set-point has latched it
/// @param deceleration of the next stop [UU/s²]
/// @return where the set-point leads, in the frame of the demand [UU]: by bits 6 and 7 of `option`,
///         as seen from where the demand would come to rest; without them, and where software
///         limits are in force, `target` itself.
[[nodiscard]] double target_on_range(const Drive& drive, double target, std::int64_t option,
                                     double deceleration);

}  // namespace vdrive
