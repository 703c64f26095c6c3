// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// What has to last before 6041h shows it.

/// @return whether demand and actual speed are zero.
[[nodiscard]] bool at_rest(const Drive& drive);

/// @return whether the demand rests on the target and the actual position was inside 6067h for
///         6068h.
[[nodiscard]] bool on_target(const Drive& drive);

/// Counts the ticks in a row for which `inside` held.
void count_ticks(bool inside, std::uint32_t& count);

/// Counts the present tick of the target window 6067h; after the plant.
void watch_target_window(Drive& drive);

/// @return bit 10 of 6041h where `reached`.
[[nodiscard]] std::uint16_t reached_when(bool reached);

}  // namespace vdrive
