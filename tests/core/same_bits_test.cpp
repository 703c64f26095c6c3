// SPDX-License-Identifier: Apache-2.0
// Bits of axes that use only what is on by default. They do not depend on compiler, processor and
// preset (docs/explanation/core.md, "Same bits").
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive {
namespace {

constexpr std::size_t kDefaultAxes = 24;
constexpr int kPinnedTicks = 4'000;

// The result of `hash_of_default_axes` at commit 9745ae17, the last one before limited jerk, the
// modes 2, 7, 9 and 10, switches with a position, the effects of a real axis and the habits of
// other drives. All of them are off here, so no bit may change. A new member of AxisStatus changes
// the number as well: take the new one from a commit that adds the member and nothing else.
constexpr std::uint64_t kHashOfDefaultAxes = 0xE8B0'2E21'7BA6'4E53;

std::int64_t mode_of_default_axis(std::size_t axis) {
  constexpr std::array<std::int64_t, 4> kPinnedModes{1, 3, 6, 8};
  return kPinnedModes[axis % kPinnedModes.size()];
}

/// Writes of a master to an axis before a tick: two moves, the second during the first; two
/// velocities; homing on the index pulse and on the current position; a stream back and forth. Then
/// a load for all, and a quick stop in motion.
void lead_default_axis(AxisBank& bank, std::size_t axis, int tick) {
  const auto write = [&bank, axis](std::uint16_t index, std::int64_t value) {
    ASSERT_EQ(bank.write(axis, {index, 0}, value), AbortCode::none);
  };
  const std::int64_t mode = mode_of_default_axis(axis);
  const auto spread = static_cast<std::int64_t>(axis) + 1;
  if (tick == 0) write(0x6060, mode);
  if (tick == 10) write(0x6040, 0x000F);
  if (tick == 2'500) write(0x5E00, 40 * spread);
  if (tick == 3'500) write(0x6040, 0x000B);
  if (mode == 1 && (tick == 50 || tick == 400)) {
    write(0x607A, tick == 50 ? 9'000 * spread : -7'000 * spread);
    write(0x6040, 0x000F);
    write(0x6040, 0x003F);
  }
  if (mode == 3 && (tick == 50 || tick == 1'500)) {
    write(0x60FF, tick == 50 ? 3'000 * spread : -4'000 * spread);
  }
  if (mode == 6 && (tick == 50 || tick == 3'000)) {
    const int by_index = axis % 8 < 4 ? 33 : 34;
    write(0x6098, tick == 50 ? by_index : 37);
    write(0x6040, 0x000F);
    write(0x6040, 0x001F);
  }
  if (mode == 8 && tick >= 50 && tick < 3'500) {
    write(0x607A, spread * (tick < 1'750 ? tick - 50 : 3'450 - tick));
  }
}

std::uint64_t hash_of_default_axes() {
  std::vector<AxisConfiguration> axes(kDefaultAxes);
  for (std::size_t axis = 0; axis < kDefaultAxes; ++axis) {
    axes[axis].model.coupling = axis % 8 < 4 ? Coupling::rigid : Coupling::two_inertia;
  }
  AxisBank bank(axes, std::chrono::microseconds{1000});
  std::uint64_t hash = 0;
  for (int tick = 0; tick < kPinnedTicks; ++tick) {
    for (std::size_t axis = 0; axis < kDefaultAxes; ++axis) lead_default_axis(bank, axis, tick);
    bank.step();
    hash = (hash ^ bank.status_hash()) * 0x9E37'79B9'7F4A'7C15U;
  }
  return hash;
}

TEST(SameBits, AreUnchangedInAxesThatUseOnlyDefaults) {
  EXPECT_EQ(hash_of_default_axes(), kHashOfDefaultAxes);
}

}  // namespace
}  // namespace vdrive
