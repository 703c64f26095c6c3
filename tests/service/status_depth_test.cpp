// SPDX-License-Identifier: Apache-2.0
#include "publish/status_depth.hpp"

#include <gtest/gtest.h>

#include <bit>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

Configuration bench_of(std::size_t axes, std::uint32_t status_every = 1) {
  Configuration configuration;
  configuration.status_every = status_every;
  configuration.axes = default_axes(axes);
  return configuration;
}

// 250 ticks of 1 ms and the one being passed on. A tick has 4 frames of 256 axes, 28,712 bytes with
// a head of 24 bytes each: 115 kB per tick, 28.8 MB in total.
TEST(StatusDepth, HoldsAQuarterOfASecond) {
  const StatusDepth depth = status_depth(bench_of(1'024));
  EXPECT_EQ(depth.images, 251U);
  EXPECT_EQ(depth.room, std::size_t{32} << 20U);
}

// Every 10th tick is published: 25 images and one more, each of 64 frames of 28.7 kB, 47.8 MB in
// total.
TEST(StatusDepth, CountsPublishedTicksOnly) {
  const StatusDepth depth = status_depth(bench_of(16'384, 10));
  EXPECT_EQ(depth.images, 26U);
  EXPECT_EQ(depth.room, std::size_t{64} << 20U);
}

// An image of 16,384 axes is larger than 1 MB, so 64 MiB hold fewer than 64 of the 251.
TEST(StatusDepth, IsBounded) {
  const StatusDepth depth = status_depth(bench_of(16'384));
  EXPECT_GE(depth.images, 4U);
  EXPECT_LT(depth.images, 64U);
  EXPECT_EQ(depth.room, kMostRoom);
}

TEST(StatusDepth, IsSmallForASmallBench) {
  const StatusDepth depth = status_depth(bench_of(1));
  EXPECT_EQ(depth.images, 251U);
  EXPECT_EQ(depth.room, std::size_t{1} << 20U);
}

// In lock-step the worker that fills an image also publishes it.
TEST(StatusDepth, IsSmallInLockStep) {
  Configuration configuration = bench_of(64);
  configuration.clock = ClockMode::lockstep;
  EXPECT_EQ(status_depth(configuration).images, 4U);
}

}  // namespace
}  // namespace vdrive::service
