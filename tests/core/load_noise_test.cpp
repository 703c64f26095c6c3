// SPDX-License-Identifier: Apache-2.0
#include "plant/load_noise.hpp"

#include "scramble.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace vdrive {
namespace {

/// The sum of four uniformly distributed numbers: mean 0, root mean square 1, maximum √12. For
/// 100,000 numbers the mean is within 6 of its standard deviations (0.0032), and so is the mean
/// square (0.0041).
TEST(LoadNoise, HasTheMeanTheRootMeanSquareAndTheLimitThatItPromises) {
  constexpr int kNumbers = 100'000;
  double sum = 0.0;
  double squares = 0.0;
  for (std::uint64_t tick = 0; tick < kNumbers; ++tick) {
    const double number = noise_of(scramble(tick));
    sum += number;
    squares += number * number;
  }
  EXPECT_NEAR(sum / kNumbers, 0.0, 0.02);
  EXPECT_NEAR(squares / kNumbers, 1.0, 0.025);
  EXPECT_NEAR(noise_of(~std::uint64_t{0}), std::sqrt(12.0), 1e-3);
  EXPECT_NEAR(noise_of(0), -std::sqrt(12.0), 1e-3);
}

}  // namespace
}  // namespace vdrive
