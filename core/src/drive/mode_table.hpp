// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/cia402/operating_mode.hpp"

#include <array>
#include <cstddef>

namespace vdrive {

// The operating modes of the drive, and the motion requests that take precedence over the active
// mode.

inline constexpr std::size_t kModeNumbers =
    static_cast<std::size_t>(kOperatingModes.back().mode) + 1;

/// Indexed by mode number; numbers without a mode are never active.
extern const std::array<const Mode*, kModeNumbers> kModes;

/// @return the active mode, 6061h.
[[nodiscard]] inline const Mode& mode_of(const Drive& drive) {
  const auto number = static_cast<std::size_t>(drive.state().mode.actual);
  ensure(number < kModes.size(), "the mode in force has a row");
  return *kModes[number];
}

/// @return the motion requested now by state, operating mode and controlword.
[[nodiscard]] MotionRequest requested_motion(const Drive& drive);

/// Makes 6061h follow 6060h. In Operation enabled, a moving axis first brakes to a standstill.
void follow_mode(Drive& drive);

}  // namespace vdrive
