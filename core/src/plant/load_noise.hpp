// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "scramble.hpp"

#include <cstdint>

namespace vdrive {

/// White noise of the load torque of an axis: a new number each tick, from seed, axis and tick.
struct LoadNoise {
  std::uint64_t stream = 0;  // from seed and axis
  std::uint64_t ticks = 0;   // since the seed was set
  double rms = 0.0;          // [N.m], 0 = none
  double load = 0.0;         // load torque without noise, as the servo uses it [UU/s²]
  double per_torque = 0.0;   // converts a torque to the unit of `load` [UU/s²/(N.m)]
};

/// @return a number with mean 0 and root mean square 1, at most 3.4641 from 0: the sum of four
///         uniformly distributed numbers, which is nearly normal and needs no function of the maths
///         library.
[[nodiscard]] constexpr double noise_of(std::uint64_t bits) noexcept {
  constexpr double kPerUnit =
      1.7320508075688772 /
      65536.0;  // the sum of 4 numbers spread over 65,536: standard deviation 65,536/√3
  constexpr std::int64_t kLargestPart = 0xFFFF;
  std::int64_t sum = -2 * kLargestPart;
  for (int part = 0; part < 4; ++part, bits >>= 16U) {
    sum += static_cast<std::int64_t>(bits & 0xFFFFU);
  }
  return static_cast<double>(sum) * kPerUnit;
}

/// @return the load torque of the next tick [UU/s²].
inline double next_load(LoadNoise& noise) noexcept {
  const double torque = noise.rms * noise_of(scramble(noise.stream + noise.ticks));
  ++noise.ticks;
  return noise.load + torque * noise.per_torque;
}

}  // namespace vdrive
