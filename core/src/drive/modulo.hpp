// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/block.hpp"
#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Effect of the position range 607Bh on a modulo axis.

/// Maps the positions of the axis into its range: 6062h, 6064h and, with one encoder, 3572h, which
/// then equals 6064h. With two encoders 3572h keeps counting, and 3573h is the difference of the
/// values shown.
void fold_numbers(const Drive& drive, NumberBlock& numbers) noexcept;

/// @param target absolute [UU], from 607Ah
/// @param option 60F2h as latched by the set-point
/// @param deceleration of the next stop [UU/s²]
/// @return the internal target of the set-point in the frame of the demand [UU]: by bits 6 and 7 of
///         `option`, relative to the position where the demand would come to rest; without these
///         bits, or with software limits in force, `target` itself.
[[nodiscard]] double target_on_range(const Drive& drive, double target, std::int64_t option,
                                     double deceleration);

}  // namespace vdrive
