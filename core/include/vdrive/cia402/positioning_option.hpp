// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive {

/// Bits of the positioning option code 60F2h (CiA 402-2, profile position mode; manual, 60F2h).
struct PositioningOption {
  static constexpr std::int64_t kRelativeBits = 0x0003;   ///< what a relative target refers to
  static constexpr std::int64_t kDirectionBits = 0x00C0;  ///< rotary axis direction option
  static constexpr unsigned kFirstDirectionBit = 6;
};

}  // namespace vdrive
