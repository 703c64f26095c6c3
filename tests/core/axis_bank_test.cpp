// SPDX-License-Identifier: Apache-2.0
// The bank: the same bits however it is stepped, snapshots, no allocation in a tick, random
// programs, power cycle, periods, refused configurations.
#include "vdrive/axis_bank.hpp"

#include "core/support/allocation_guard.hpp"
#include "core/support/axis_under_test.hpp"
#include "support/programs/generator.hpp"
#include "support/programs/model.hpp"
#include "support/random_cases.hpp"
#include "vdrive/cia402/controlword.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <malloc.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AllocationGuard;
using test::AxisUnderTest;
using test::Random;

ObjectAddress object(std::string_view variable_name) {
  return AxisUnderTest::address_of(variable_name);
}

/// Axes of every kind, so that there are blocks of both couplings and partly filled blocks.
std::vector<AxisConfiguration> mixed_axes(std::size_t count) {
  std::vector<AxisConfiguration> axes(count);
  for (std::size_t i = 0; i < count; ++i) {
    AxisConfiguration& axis = axes[i];
    axis.initial_position = static_cast<std::int32_t>(i) * 1'000;
    axis.model.coupling = i % 3 == 1 ? Coupling::two_inertia : Coupling::rigid;
    axis.model.feedback = i % 2 == 0 ? Feedback::dual_encoder : Feedback::single_encoder;
    axis.model.load_inertia = 1.0e-4 * static_cast<double>(1 + i % 7);
    axis.model.backlash = i % 4 == 1 ? 1.0e-3 : 0.0;
    if (i % 5 == 2) {
      axis.parameters.push_back({object("gear_ratio_denominator"), 3});
    }
  }
  return axes;
}

/// A command that suits the axis's state; now and then, a test-bench input to switch on or off.
test::Write draw(const AxisBank& bank, std::size_t axis, Random& random) {
  if (!random.one_in(8)) return test::draw_write(bank.status(axis), random);
  for (std::uint16_t input = 0x5E00; input <= 0x5E0A; ++input) {
    if (bank.read(axis, {input, 0}).value != 0) return {{input, 0}, 0};
  }
  return random.one_in(4) ? test::draw_disturbance(random)
                          : test::draw_write(bank.status(axis), random);
}

/// Banks with the same status and the same `random` get the same writes.
void write_randomly(AxisBank& bank, Random& random) {
  for (std::size_t axis = 0; axis < bank.size(); ++axis) {
    if (!random.one_in(20)) continue;
    const test::Write write = random.one_in(10)
                                  ? test::Write{object("profile_dec"), random.between(0, 999'999)}
                                  : draw(bank, axis, random);
    bank.write(axis, write.object, write.value);
  }
}

std::vector<std::uint64_t> run(AxisBank& bank, int ticks, auto step) {
  Random random(7);
  std::vector<std::uint64_t> hashes;
  for (int tick = 0; tick < ticks; ++tick) {
    write_randomly(bank, random);
    step(bank);
    hashes.push_back(bank.status_hash());
  }
  return hashes;
}

TEST(AxisBank, GivesTheSameBitsForEveryPartitionOfItsGroups) {
  const std::vector<AxisConfiguration> axes = mixed_axes(61);
  AxisBank whole(axes, microseconds{1000});
  AxisBank single(axes, microseconds{1000});
  AxisBank backwards(axes, microseconds{1000});
  ASSERT_GT(whole.group_count(), 2U);

  const auto expected = run(whole, 600, [](AxisBank& bank) {
    bank.step();
  });
  const auto one_by_one = run(single, 600, [](AxisBank& bank) {
    for (std::size_t group = 0; group < bank.group_count(); ++group) {
      bank.step_groups(group, group + 1);
    }
  });
  const auto in_reverse = run(backwards, 600, [](AxisBank& bank) {
    const std::size_t middle = bank.group_count() / 2;
    bank.step_groups(middle, bank.group_count());
    bank.step_groups(0, middle);
  });

  EXPECT_EQ(one_by_one, expected);
  EXPECT_EQ(in_reverse, expected);
  EXPECT_NE(expected.front(), expected.back());
}

TEST(AxisBank, GivesTheSameBitsFromSeveralThreads) {
  const std::vector<AxisConfiguration> axes = mixed_axes(61);
  AxisBank one(axes, microseconds{1000});
  AxisBank several(axes, microseconds{1000});

  const auto expected = run(one, 200, [](AxisBank& bank) {
    bank.step();
  });
  const auto threaded = run(several, 200, [](AxisBank& bank) {
    const std::size_t third = bank.group_count() / 3;
    std::thread first([&] {
      bank.step_groups(0, third);
    });
    std::thread second([&] {
      bank.step_groups(third, 2 * third);
    });
    bank.step_groups(2 * third, bank.group_count());
    first.join();
    second.join();
  });

  EXPECT_EQ(threaded, expected);
}

TEST(AxisBank, BehavesTheSameWhateverItsNeighbours) {
  const std::vector<AxisConfiguration> axes = mixed_axes(20);
  AxisBank bank(axes, microseconds{1000});
  for (std::size_t i = 0; i < axes.size(); ++i) {
    bank.write(i, object("op_mode_cmd"), 1);
    bank.write(i, object("position_user_target_value"), 123'456);
  }
  std::vector<AxisUnderTest> alone;
  for (const AxisConfiguration& configuration : axes) {
    alone.emplace_back(configuration);
    alone.back().write("op_mode_cmd", 1);
    alone.back().write("position_user_target_value", 123'456);
  }
  for (int tick = 0; tick < 1'500; ++tick) {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const std::uint16_t word = tick < 10 ? 0x0F : 0x3F;
      bank.write(i, object("ds402_controlword"), word);
      alone[i].controlword(word);
      alone[i].step();
    }
    bank.step();
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const AxisStatus& here = bank.status(i);
      const AxisStatus& there = alone[i].status();
      ASSERT_EQ(here.load_position_actual_value, there.load_position_actual_value) << i;
      ASSERT_EQ(here.motor_velocity_actual_value, there.motor_velocity_actual_value) << i;
      ASSERT_EQ(here.current_actual_value, there.current_actual_value) << i;
      ASSERT_EQ(here.ds402_statusword, there.ds402_statusword) << i;
    }
  }
}

TEST(AxisBank, RestoringASnapshotRepeatsTheRunBitByBit) {
  AxisBank bank(mixed_axes(13), microseconds{1000});
  run(bank, 300, [](AxisBank& b) {
    b.step();
  });
  const AxisBank::Snapshot middle = bank.snapshot();
  const auto first = run(bank, 300, [](AxisBank& b) {
    b.step();
  });

  bank.restore(middle);
  const auto second = run(bank, 300, [](AxisBank& b) {
    b.step();
  });
  EXPECT_EQ(second, first);

  AxisBank other(mixed_axes(13), microseconds{1000});
  other.restore(middle);
  EXPECT_EQ(run(other, 300,
                [](AxisBank& b) {
                  b.step();
                }),
            first);
}

TEST(AxisBank, ACopyIsIndependentOfItsOriginal) {
  AxisBank bank(mixed_axes(5), microseconds{1000});
  bank.write(0, object("ds402_controlword"), 0x0F);
  AxisBank copy(bank);
  const std::uint64_t before = copy.status_hash();
  bank.step();
  EXPECT_EQ(copy.status_hash(), before);
  copy.step();
  EXPECT_EQ(copy.status_hash(), bank.status_hash());
  AxisBank assigned(mixed_axes(2), microseconds{2000});
  assigned = bank;
  EXPECT_EQ(assigned.size(), 5U);
  EXPECT_EQ(assigned.status_hash(), bank.status_hash());
}

TEST(AxisBank, CopyAndSelfAssignmentKeepTheState) {
  AxisBank bank(mixed_axes(5), microseconds{1000});
  bank.write(0, object("ds402_controlword"), 0x0F);
  bank.step();
  const std::uint64_t hash = bank.status_hash();
  const AxisBank& itself = bank;
  bank = itself;
  EXPECT_EQ(bank.status_hash(), hash);
  AxisBank moved(mixed_axes(1), microseconds{2000});
  moved = std::move(bank);
  EXPECT_EQ(moved.status_hash(), hash);
  EXPECT_EQ(moved.period(), microseconds{1000});
}

TEST(AxisBank, ACopiedSnapshotOutlivesItsOriginal) {
  AxisBank bank(mixed_axes(5), microseconds{1000});
  const auto hash_after_a_step = [&bank](const AxisBank::Snapshot& snapshot) {
    bank.restore(snapshot);
    bank.step();
    return bank.status_hash();
  };
  auto original = std::make_unique<AxisBank::Snapshot>(bank.snapshot());
  const std::uint64_t expected = hash_after_a_step(*original);
  const AxisBank::Snapshot copy(*original);
  bank.write(0, object("test_over_current"), 1);
  bank.step();
  AxisBank::Snapshot assigned = bank.snapshot();
  assigned = *original;
  const AxisBank::Snapshot& itself = assigned;
  assigned = itself;
  original.reset();
  EXPECT_EQ(hash_after_a_step(copy), expected);
  EXPECT_EQ(hash_after_a_step(assigned), expected);
}

TEST(AxisBank, ContinuesFromTheBytesOfASnapshotLikeTheBankThatWroteIt) {
  Random random(17);
  AxisBank bank(mixed_axes(13), microseconds{1000});
  for (int tick = 0; tick < 300; ++tick) {  // also changes parameters: gear, torque limits
    write_randomly(bank, random);
    bank.step();
  }
  const auto bytes = bank.snapshot().bytes();
  AxisBank other(mixed_axes(13), microseconds{1000});
  other.restore(other.snapshot_from(bytes));
  Random same_random = random;
  for (int tick = 0; tick < 300; ++tick) {
    write_randomly(bank, random);
    bank.step();
    write_randomly(other, same_random);
    other.step();
    ASSERT_EQ(other.status_hash(), bank.status_hash()) << "tick " << tick;
  }
}

#ifdef __GLIBC__
/// Fills newly allocated memory, and the stack below this frame, with a byte.
class MemoryFilledWith {
 public:
  explicit MemoryFilledWith(int byte) {
    mallopt(M_PERTURB, 0xFF ^ byte);
    fill_stack(byte);
  }

  MemoryFilledWith(const MemoryFilledWith&) = delete;
  MemoryFilledWith& operator=(const MemoryFilledWith&) = delete;
  MemoryFilledWith(MemoryFilledWith&&) = delete;
  MemoryFilledWith& operator=(MemoryFilledWith&&) = delete;

  ~MemoryFilledWith() { mallopt(M_PERTURB, 0); }

 private:
  [[gnu::noinline]] static void fill_stack(int byte) {
    std::array<char, 65'536> frame;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    std::memset(frame.data(), byte, frame.size());
    asm volatile("" : : "r"(frame.data()) : "memory");  // NOLINT(hicpp-no-assembler)
  }
};

// If snapshots depended on what was in memory before, journals would contain process memory, and
// two journals of the same program would differ.
TEST(AxisBank, WritesTheSameBytesOfASnapshotWhateverWasInTheMemoryBefore) {
  const auto bytes_after_writes = [](int byte) {
    const MemoryFilledWith filled(byte);
    Random random(18);
    AxisBank bank(mixed_axes(13), microseconds{1000});
    for (int tick = 0; tick < 100; ++tick) {
      write_randomly(bank, random);
      bank.step();
    }
    return bank.snapshot().bytes();
  };
  const auto one = bytes_after_writes(0x55);
  const auto other = bytes_after_writes(0xAA);
  ASSERT_EQ(one.size(), other.size());
  const auto difference = std::ranges::mismatch(one, other).in1;
  EXPECT_EQ(difference, one.end()) << "first at byte " << difference - one.begin();
}
#endif

// ---- noise of the load -------------------------------------------------------------------------

/// `mixed_axes` with load noise of 0.05 N.m root mean square. Its peaks exceed the Coulomb friction
/// of 0.05 N.m, so the axes move without power.
AxisBank noisy_bank(std::uint64_t seed) {
  AxisBank bank(mixed_axes(13), microseconds{1000});
  for (std::size_t axis = 0; axis < bank.size(); ++axis) bank.set_load_noise(axis, 0.05, seed);
  return bank;
}

std::uint64_t hash_after(AxisBank& bank, int ticks) {
  for (int tick = 0; tick < ticks; ++tick) bank.step();
  return bank.status_hash();
}

TEST(LoadNoise, IsTheSameForTheSameSeedAndAnotherForAnother) {
  AxisBank first = noisy_bank(1);
  AxisBank same = noisy_bank(1);
  AxisBank other = noisy_bank(2);
  const std::uint64_t hash = hash_after(first, 1000);
  EXPECT_EQ(hash_after(same, 1000), hash);
  EXPECT_NE(hash_after(other, 1000), hash);
}

TEST(LoadNoise, ContinuesFromASnapshotAndItsBytes) {
  AxisBank bank = noisy_bank(3);
  static_cast<void>(hash_after(bank, 100));
  const auto bytes = bank.snapshot().bytes();
  const std::uint64_t hash = hash_after(bank, 500);
  AxisBank other(mixed_axes(13), microseconds{1000});
  other.restore(other.snapshot_from(bytes));
  EXPECT_EQ(hash_after(other, 500), hash);
}

TEST(LoadNoise, DoesNotDependOnTheOrderOfTheGroups) {
  AxisBank bank = noisy_bank(4);
  AxisBank other = noisy_bank(4);
  for (int tick = 0; tick < 300; ++tick) {
    bank.step();
    for (std::size_t group = other.group_count(); group > 0; --group) {
      other.step_groups(group - 1, group);
    }
    ASSERT_EQ(other.status_hash(), bank.status_hash()) << "tick " << tick;
  }
}

TEST(LoadNoise, OfZeroLeavesEveryBitAsItIs) {
  AxisBank bank(mixed_axes(13), microseconds{1000});
  AxisBank silent(mixed_axes(13), microseconds{1000});
  for (std::size_t axis = 0; axis < silent.size(); ++axis) silent.set_load_noise(axis, 0.0, 7);
  EXPECT_EQ(hash_after(silent, 300), hash_after(bank, 300));
  AxisBank stopped = noisy_bank(5);
  for (std::size_t axis = 0; axis < stopped.size(); ++axis) stopped.set_load_noise(axis, 0.0, 5);
  EXPECT_EQ(hash_after(stopped, 300), hash_after(bank, 0));
}

TEST(LoadNoise, ReachesAnAxisThatHasSettled) {
  const std::vector<AxisConfiguration> axes(8);
  AxisBank bank(axes, microseconds{1000});
  for (int tick = 0; tick < 5000; ++tick) bank.step();
  const std::int32_t position = bank.status(3).motor_position_actual_value;
  bank.set_load_noise(3, 1.0, 1);
  for (int tick = 0; tick < 1000; ++tick) bank.step();
  EXPECT_NE(bank.status(3).motor_position_actual_value, position);
  EXPECT_EQ(bank.status(4).motor_position_actual_value, 0);
}

/// Five axes are lanes 0 to 4 of one block. Noise on lane 4 changes several bytes of the state. The
/// first one that goes from 0 to 0x10 is the mask of the lanes with noise.
TEST(AxisBank, RefusesBytesWithALaneThatItsBlockDoesNotHave) {
  AxisBank bank(std::vector<AxisConfiguration>(5), microseconds{1000});
  const auto before = bank.snapshot().bytes();
  bank.set_load_noise(4, 1.0, 1);
  auto bytes = bank.snapshot().bytes();
  EXPECT_NO_THROW(static_cast<void>(bank.snapshot_from(bytes)));
  std::size_t mask = 0;
  while (before.at(mask) != std::byte{0} || bytes[mask] != std::byte{0x10}) ++mask;
  for (const std::byte lanes : {std::byte{0x20}, std::byte{0x80}}) {
    bytes[mask] = lanes;
    EXPECT_THROW(static_cast<void>(bank.snapshot_from(bytes)), std::invalid_argument);
  }
}

TEST(AxisBank, RefusesBytesThatAreNotASnapshotOfItsAxes) {
  const AxisBank bank(mixed_axes(13), microseconds{1000});
  auto bytes = bank.snapshot().bytes();
  const AxisBank smaller(mixed_axes(5), microseconds{1000});
  EXPECT_THROW(static_cast<void>(smaller.snapshot_from(bytes)), std::invalid_argument);
  bytes.pop_back();
  EXPECT_THROW(static_cast<void>(bank.snapshot_from(bytes)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(bank.snapshot_from({})), std::invalid_argument);
}

TEST(AxisBank, RefusesBytesWithAModeThatTheDriveDoesNotHave) {
  AxisBank bank(mixed_axes(1), microseconds{1000});
  bank.write(0, {0x6060, 0}, 1);
  const auto before = bank.snapshot().bytes();
  bank.write(0, {0x6060, 0}, 8);
  const auto bytes = bank.snapshot().bytes();
  EXPECT_NO_THROW(static_cast<void>(bank.snapshot_from(bytes)));
  for (const int mode : {5, 11, -1}) {
    auto forged = bytes;
    // The bytes that went from 1 to 8 are the mode: its register, the requested mode, and the mode
    // in force.
    for (std::size_t i = 0; i < forged.size(); ++i) {
      if (before[i] == std::byte{1} && bytes[i] == std::byte{8}) {
        forged[i] = static_cast<std::byte>(mode);
      }
    }
    EXPECT_THROW(static_cast<void>(bank.snapshot_from(forged)), std::invalid_argument) << mode;
  }
}

TEST(AxisBank, RefusesBytesWithAHomingRunByAMethodThatTheDriveDoesNotHave) {
  const AxisBank bank(mixed_axes(1), microseconds{1000});
  const auto bytes_of_run = [](std::int64_t method) {
    AxisBank homing(mixed_axes(1), microseconds{1000});
    homing.write(0, {0x6060, 0}, 6);
    homing.write(0, {0x6040, 0}, 0x0F);
    homing.step();
    homing.write(0, {0x6098, 0}, method);
    homing.write(0, {0x6040, 0}, 0x1F);
    return homing.snapshot().bytes();
  };
  const auto one = bytes_of_run(1);
  const auto two = bytes_of_run(2);
  EXPECT_NO_THROW(static_cast<void>(bank.snapshot_from(two)));
  for (const int method : {0, 15, 36, -5}) {
    auto forged = two;
    // The bytes that differ are the method: its register and the method of the run.
    for (std::size_t i = 0; i < forged.size(); ++i) {
      if (one[i] == std::byte{1} && two[i] == std::byte{2}) {
        forged[i] = static_cast<std::byte>(method);
      }
    }
    EXPECT_THROW(static_cast<void>(bank.snapshot_from(forged)), std::invalid_argument) << method;
  }
}

TEST(AxisBank, SavesIntoASnapshotWithoutAllocation) {
  AxisBank bank(mixed_axes(13), microseconds{1000});
  AxisBank::Snapshot snapshot = bank.snapshot();
  bank.write(0, object("ds402_controlword"), 0x0F);
  bank.step();
  {
    const AllocationGuard guard;
    bank.save(snapshot);
    EXPECT_EQ(guard.count(), 0U);
  }
  AxisBank other(mixed_axes(13), microseconds{1000});
  other.restore(snapshot);
  EXPECT_EQ(other.status_hash(), bank.status_hash());
}

TEST(AxisBank, RefusesASnapshotOfOtherAxes) {
  const AxisBank five(mixed_axes(5), microseconds{1000});
  AxisBank six(mixed_axes(6), microseconds{1000});
  AxisBank slower(mixed_axes(5), microseconds{2000});
  EXPECT_THROW(six.restore(five.snapshot()), std::invalid_argument);
  EXPECT_THROW(slower.restore(five.snapshot()), std::invalid_argument);
}

TEST(AxisBank, DoesNotAllocateInWriteReadAndStep) {
  AxisBank bank(mixed_axes(40), microseconds{1000});
  const std::vector<ObjectAddress> objects{object("ds402_statusword"),
                                           object("error_history_1"),
                                           object("position_demand_value"),
                                           {0x2000, 0},
                                           {0x6041, 7}};
  std::uint64_t allocations = 0;
  {
    const AllocationGuard guard;
    Random random(3);
    for (int tick = 0; tick < 500; ++tick) {
      write_randomly(bank, random);
      bank.step();
      for (std::size_t axis = 0; axis < bank.size(); ++axis) {
        for (const ObjectAddress& address : objects) static_cast<void>(bank.read(axis, address));
        static_cast<void>(bank.write(axis, {0x2000, 0}, 1));
        static_cast<void>(bank.power_state(axis));
      }
    }
    bank.power_cycle(3);
    bank.report_connection_loss(4);
    allocations = guard.count();
  }
  EXPECT_EQ(allocations, 0U);
}

TEST(AxisBank, DoesNotAllocateWithLimitedJerk) {
  AxisBank bank(mixed_axes(13), microseconds{1000});
  for (std::size_t axis = 0; axis < bank.size(); ++axis) {
    ASSERT_EQ(bank.write(axis, object("motion_profile_type"), 3), AbortCode::none);
    ASSERT_EQ(bank.write(axis, object("profile_jerk_1"), 10'000'000), AbortCode::none);
    ASSERT_EQ(bank.write(axis, object("op_mode_cmd"), 1), AbortCode::none);
    ASSERT_EQ(bank.write(axis, object("ds402_controlword"), 0x0F), AbortCode::none);
  }
  bank.step();
  std::uint64_t allocations = 0;
  {
    const AllocationGuard guard;
    Random random(5);
    for (int tick = 0; tick < 500; ++tick) {
      for (std::size_t axis = 0; axis < bank.size(); ++axis) {
        if (!random.one_in(20)) continue;
        bank.write(axis, object("position_user_target_value"),
                   static_cast<std::int64_t>(random.below(400'000)) - 200'000);
        bank.write(axis, object("ds402_controlword"), random.one_in(4) ? 0x010F : 0x2F);
      }
      bank.step();
      for (std::size_t axis = 0; axis < bank.size(); ++axis) {
        bank.write(axis, object("ds402_controlword"), 0x3F);
      }
      bank.step();
    }
    allocations = guard.count();
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_NE(bank.status(0).position_demand_value, 0) << "it moved";
}

TEST(AxisBank, DoesNotAllocateForAnyObjectThatCanBeWritten) {
  AxisBank bank(mixed_axes(6), microseconds{1000});
  std::uint64_t allocations = 0;
  {
    const AllocationGuard guard;
    for (const ObjectDescription& row : kObjectTable) {
      for (std::size_t axis = 0; axis < bank.size(); ++axis) {
        bank.write(axis, row.address, row.upper_limit);
        bank.write(axis, row.address, row.default_value);
      }
      bank.step();
    }
    allocations = guard.count();
  }
  EXPECT_EQ(allocations, 0U);
}

TEST(AllocationGuardOfTheTests, CountsAllocations) {
#ifdef VDRIVE_WATCHES_THREADS
  GTEST_SKIP() << "the sanitizer of threads owns operator new";
#endif
  const AllocationGuard guard;
  const auto number = std::make_unique<int>(1);
  EXPECT_EQ(*number, 1);
  EXPECT_GE(guard.count(), 1U);
}

TEST(AxisBank, WritingTheSameValueAgainChangesNoBit) {
  const std::vector<AxisConfiguration> axes = mixed_axes(8);
  AxisBank quiet(axes, microseconds{1000});
  AxisBank chatty(axes, microseconds{1000});
  const auto write_both = [&](std::string_view name, std::int64_t value) {
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      quiet.write(axis, object(name), value);
      chatty.write(axis, object(name), value);
    }
  };
  Random random(11);
  write_both("op_mode_cmd", 1);
  for (int tick = 0; tick < 1'500; ++tick) {
    if (tick % 97 == 0) {
      write_both("position_user_target_value",
                 static_cast<std::int64_t>(random.below(200'000)) - 100'000);
      write_both("profile_acc", 10'000 + static_cast<std::int64_t>(random.below(1'000'000)));
      write_both("ds402_controlword", test::draw_controlword(quiet.status(0), random));
    }
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      for (const ObjectDescription& row : kObjectTable) {
        if (row.access == Access::read_write && row.address.index != 0x1003 &&
            row.address.index != 0x1010 && row.address.index != 0x1011) {
          chatty.write(axis, row.address, chatty.read(axis, row.address).value);
        }
      }
    }
    quiet.step();
    chatty.step();
    ASSERT_EQ(quiet.status_hash(), chatty.status_hash()) << "tick " << tick;
  }
}

/// Now and then, writes to an axis of both banks something that ends its rest or must not end it:
/// moves, windows and their times, disturbances, loss of power.
void disturb_rest(AxisBank& a, AxisBank& b, Random& random) {
  const std::array<std::pair<std::string_view, std::int64_t>, 9> writes{{
      {"position_target_reached_window_time", 900},
      {"position_target_reached_window", 2'000},
      {"following_error_window", 3'000},
      {"test_load_torque", 400},
      {"position_user_target_value", 20'000},
      {"test_over_current", 2},
      {"op_mode_cmd", 2},
      {"gear_ratio_numerator", 3},
      {"app_position_limit_switch", 2},
  }};
  for (std::size_t axis = 0; axis < a.size(); ++axis) {
    if (!random.one_in(150)) continue;
    const auto& [name, bound] = writes[random.below(writes.size())];
    const test::Write write = random.one_in(2)
                                  ? test::Write{object("ds402_controlword"),
                                                test::draw_controlword(a.status(axis), random)}
                                  : test::Write{object(name), random.between(0, bound - 1)};
    a.write(axis, write.object, write.value);
    b.write(axis, write.object, write.value);
  }
}

TEST(AxisBank, AnAxisAtRestBehavesAsIfEveryTickWereCalculated) {
  const std::uint64_t seeds = test::case_count(60, 1'000);
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const std::vector<AxisConfiguration> axes = mixed_axes(11);
    AxisBank resting(axes, microseconds{1000});
    AxisBank watched(axes, microseconds{1000});
    Random random(seed);
    for (AxisBank* bank : {&resting, &watched}) {
      for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        bank->write(axis, object("op_mode_cmd"), 1);
        bank->write(axis, object("ds402_controlword"), 0x0F);
      }
    }
    for (int tick = 0; tick < 3'000; ++tick) {
      disturb_rest(resting, watched, random);
      for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        // After a write, the next tick of an axis is calculated in full.
        watched.write(axis, object("profile_acc"), watched.read(axis, object("profile_acc")).value);
      }
      resting.step();
      watched.step();
      ASSERT_EQ(resting.status_hash(), watched.status_hash()) << "tick " << tick;
    }
  }
}

TEST(AxisBank, TheTargetReachedTimeRunsWhileNothingOfAnAxisChanges) {
  // After 25 s on the target 6068h is raised to 20 s: bit 10 stays set. Then it is raised to 60 s:
  // bit 10 is cleared. Ten seconds after the move the integrator of the velocity loop has settled,
  // too.
  AxisUnderTest axis;
  axis.enable();
  axis.write("position_user_target_value", 10'000);
  axis.command(0x001F);
  axis.command(0x000F);
  ASSERT_NE(axis.step_until_reached(5'000), 0U);
  axis.step(25'000);
  axis.write("position_target_reached_window_time", 20'000);
  axis.step();
  EXPECT_TRUE(axis.reached());
  axis.write("position_target_reached_window_time", 60'000);
  axis.step();
  EXPECT_FALSE(axis.reached());
  axis.step(60'000 - 25'000 + 1'000);
  EXPECT_TRUE(axis.reached());
}

TEST(AxisBank, EachControlwordBetweenTwoStepsTakesEffect) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 1);
  axis.controlword(0x0006);
  EXPECT_EQ(axis.axis().power_state(), PowerState::ready_to_switch_on);
  axis.controlword(0x0007);
  EXPECT_EQ(axis.axis().power_state(), PowerState::switched_on);
  axis.controlword(0x000F);
  EXPECT_EQ(axis.axis().power_state(), PowerState::operation_enabled);
  axis.controlword(0x0000);
  axis.controlword(0x0006);
  EXPECT_EQ(axis.axis().power_state(), PowerState::ready_to_switch_on);
  EXPECT_EQ(axis.statusword(), 0x0250) << "the image is that of the last tick";
  EXPECT_EQ(axis.step(), 0x0231);
}

TEST(AxisBank, TwoSetPointsInOneTickBecomeTheActiveAndTheBufferedOne) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("position_user_target_value", 5'000);
  axis.controlword(0x001F);
  axis.controlword(0x000F);
  axis.write("position_user_target_value", 7'000);
  axis.controlword(0x001F);
  axis.controlword(0x000F);
  axis.write("position_user_target_value", 9'000);
  axis.controlword(0x001F);
  EXPECT_EQ(axis.step(), 0x1237);
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
  axis.step_until_reached(5'000);
  EXPECT_EQ(axis.demand(), 7'000);
}

TEST(AxisBank, IgnoredSetPointsAreCountedBeforeTheNextTick) {
  AxisBank bank(mixed_axes(1), microseconds{1000});
  bank.write(0, object("ds402_controlword"), 0x001F);
  EXPECT_EQ(bank.ignored_set_points(0), 1U);
  EXPECT_EQ(bank.status(0).ignored_set_points, 0U);
  bank.step();
  EXPECT_EQ(bank.status(0).ignored_set_points, 1U);
}

// ---- random programs ---------------------------------------------------------------------------

/// Axes of every kind that the generator draws, with a program and a watch for each of them.
class WatchedBank {
 public:
  explicit WatchedBank(std::uint64_t seed) : random_(seed) {
    std::vector<AxisConfiguration> axes;
    for (const test::DrawnAxis& drawn : test::draw_axes(kAxes, true, random_)) {
      AxisConfiguration& axis = axes.emplace_back();
      axis.model = drawn.model;
      axis.parameters = drawn.parameters;
      watches_.emplace_back(drawn.limits, kPeriod);
    }
    bank_.emplace(axes, kPeriod);
    for (axis_ = 0; axis_ < kAxes; ++axis_) {
      watches_[axis_].begin(bank_->status(axis_), bank_->power_state(axis_));
    }
  }

  /// @return the first violation and the program of its axis; empty if there is none.
  std::string run(int ticks) {
    for (int tick = 0; tick < ticks && violation_.empty(); ++tick) {
      for (axis_ = 0; axis_ < kAxes; ++axis_) {
        if (random_.one_in(20)) note("tick " + std::to_string(tick) + ": " + act());
      }
      bank_->step();
      for (axis_ = 0; axis_ < kAxes; ++axis_) check();
    }
    return violation_;
  }

 private:
  static constexpr std::size_t kAxes = 6;
  static constexpr microseconds kPeriod{1000};
  static constexpr ObjectAddress kControlword{0x6040, 0};

  void note(const std::string& line) { programmes_.at(axis_) += line + '\n'; }

  /// @return a description of the action.
  std::string act() {
    test::AxisCauses& causes = causes_.at(axis_);
    if (random_.one_in(200)) {
      bank_->power_cycle(axis_);
      causes.cycled = true;
      return "power_cycle()";
    }
    if (random_.one_in(200)) {
      bank_->report_connection_loss(axis_);
      causes.lost = true;
      return "report_connection_loss()";
    }
    const test::Write write = draw(*bank_, axis_, random_);
    const auto before = static_cast<std::uint16_t>(bank_->read(axis_, kControlword).value);
    const auto [code, violated] = test::write_to(*bank_, axis_, write);
    if (violated != nullptr) violation_ = programmes_.at(axis_) + to_string(write) + violated;
    if (code == AbortCode::none && write.object == kControlword) {
      const PowerCommand command = decode_command(static_cast<std::uint16_t>(write.value), before);
      causes.commanded = true;
      causes.switched_off =
          command == PowerCommand::disable_voltage || command == PowerCommand::shutdown;
    }
    return to_string(write);
  }

  void check() {
    test::AxisCauses causes = std::exchange(causes_.at(axis_), {});
    for (std::uint16_t input = 0x5E00; input <= 0x5E0A; ++input) {
      if (bank_->read(axis_, {input, 0}).value != 0) causes.has_test_input = true;
    }
    causes.encoder_fails = bank_->read(axis_, {0x5E04, 0}).value != 0;
    watches_[axis_].check(bank_->status(axis_), bank_->power_state(axis_), causes);
    if (const auto& violation = watches_[axis_].violation()) {
      violation_ = programmes_.at(axis_) + violation->invariant + ", expected " +
                   violation->expected + ": " + violation->seen;
    }
  }

  Random random_;
  std::optional<AxisBank> bank_;
  std::vector<test::AxisWatch> watches_;
  std::array<test::AxisCauses, kAxes> causes_;
  std::array<std::string, kAxes> programmes_;
  std::size_t axis_ = 0;  ///< the one being commanded
  std::string violation_;
};

TEST(AxisBank, KeepsTheInvariantsOfEachAxisInRandomProgrammes) {
  const std::uint64_t seeds = test::case_count(50, 2'000);
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    ASSERT_EQ(WatchedBank(seed).run(2'000), "") << "seed " << seed;
  }
}

// ---- any value of any object -------------------------------------------------------------------

std::int64_t any_value(const ObjectDescription& row, Random& random) {
  switch (random.below(4)) {
    case 0:
      return row.lower_limit;
    case 1:
      return row.upper_limit;
    case 2:
      return row.default_value;
    default:
      return row.lower_limit +
             static_cast<std::int64_t>(
                 random.bits() % static_cast<std::uint64_t>(row.upper_limit - row.lower_limit + 1));
  }
}

/// A gear of 2^32 to 1 or a load of 2 MN.m spins an elastic pair up until a double can no longer
/// represent the twist of its shaft; coasting down would take hours.
bool beyond_physics(const ObjectDescription& row, std::int64_t value) {
  const bool scales = row.address.index == 0x3576 || row.address.index == 0x3577 ||
                      row.address.index == 0x5E00 || row.address.index == 0x6076;
  return scales && std::abs(value) > 100'000;
}

/// For `ticks`, writes arbitrary values that the dictionary allows, and moves.
void abuse(AxisUnderTest& axis, Random& random, std::uint64_t ticks, bool physical) {
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    if (random.one_in(10)) {
      const ObjectDescription& row = kObjectTable[random.below(kObjectTable.size())];
      const std::int64_t value = any_value(row, random);
      if (!physical || !beyond_physics(row, value)) {
        static_cast<void>(axis.axis().write(row.address, value));
      }
    }
    if (random.one_in(20)) {
      const std::array<std::uint16_t, 6> words{0x80, 0x0F, 0x3F, 0x7F, 0x10F, 0x06};
      static_cast<void>(axis.try_write("op_mode_cmd", 1));
      axis.controlword(words[random.below(words.size())]);
    }
    axis.step();
    const char* const violated = test::violated_invariant(axis.status(), axis.state(),
                                                          axis.axis().read({0x5E20, 0x0C}).value);
    ASSERT_EQ(violated, nullptr) << violated;
  }
}

/// After any writes, an axis works again once its defaults are restored: no infinity and no NaN has
/// got into its state.
void expect_usable(AxisUnderTest& axis) {
  for (const ObjectDescription& row : kObjectTable) {
    if (row.access == Access::read_write) {
      static_cast<void>(axis.axis().write(row.address, row.default_value));
    }
  }
  axis.axis().power_cycle();
  axis.write("test_blocked_load", 1);  // the load may still be spinning
  axis.step(2'000);
  axis.write("test_blocked_load", 0);
  axis.step(5'000);
  axis.enable();  // removes whole turns from positions that an extreme gear has made huge
  axis.step(1'000);
  axis.command(0x0006);
  axis.step(1'000);
  axis.enable();
  ASSERT_EQ(axis.statusword(), 0x0637);
  const std::int32_t start = axis.demand();
  axis.write("position_user_target_value", 1'000);
  axis.command(0x007F);
  ASSERT_NE(axis.step_until_reached(5'000), 0U);
  axis.step(1'000);
  ASSERT_NEAR(axis.demand() - start, 1'000, 50) << "60F2h = 2: from the actual position";
  ASSERT_NEAR(axis.actual(), axis.demand(), 2);
}

TEST(AxisBank, SurvivesAnyValueThatTheDictionaryAllows) {
  const std::uint64_t rounds = test::case_count(60, 3'000);
  for (std::uint64_t seed = 0; seed < rounds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    AxisConfiguration configuration;
    configuration.model.coupling = seed % 2 == 0 ? Coupling::rigid : Coupling::two_inertia;
    configuration.model.feedback = seed % 4 < 2 ? Feedback::dual_encoder : Feedback::single_encoder;
    AxisUnderTest axis(configuration);
    Random random(seed);
    ASSERT_NO_FATAL_FAILURE(
        abuse(axis, random, 2'000, configuration.model.coupling == Coupling::two_inertia));
    ASSERT_NO_FATAL_FAILURE(expect_usable(axis));
    abuse(axis, random, 500, false);  // for the sanitizers only
  }
}

// ---- power cycle -------------------------------------------------------------------------------

TEST(PowerCycle, SetsInitialValuesKeepsTheMechanicalStateAndClearsFaults) {
  AxisConfiguration configuration;
  configuration.initial_position = 100;
  configuration.parameters = {{object("profile_velocity"), 3'000}};
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.write("position_user_target_value", 10'000);
  axis.command(0x003F);
  axis.step(6'000);
  axis.write("profile_velocity", 5);
  axis.write("profile_acc", 7);
  axis.write("test_over_current", 1);
  axis.step(5);
  axis.write("test_over_current", 0);
  ASSERT_EQ(axis.state(), PowerState::fault);
  const std::int32_t position = axis.actual();

  axis.axis().power_cycle();

  EXPECT_EQ(axis.state(), PowerState::not_ready_to_switch_on);
  EXPECT_EQ(axis.statusword(), 0x0200) << "sheet 1.1";
  EXPECT_EQ(axis.step(), 0x0250);
  EXPECT_EQ(axis.actual(), position);
  EXPECT_EQ(axis.demand(), position);
  EXPECT_EQ(axis.read("profile_velocity"), 3'000);
  EXPECT_EQ(axis.read("profile_acc"), 409'600);
  EXPECT_EQ(axis.read("op_mode_actual"), 0);
  EXPECT_EQ(axis.read("op_mode_cmd"), 0);
  EXPECT_EQ(axis.read("position_user_target_value"), 0);
  EXPECT_EQ(axis.read("ds402_controlword"), 0);
  EXPECT_EQ(axis.read("error_code"), 0);
  EXPECT_EQ(axis.read("error_history_count"), 0);
  EXPECT_EQ(axis.status().fault_count, 0U);
  EXPECT_EQ(axis.status().ignored_set_points, 0U);
}

TEST(PowerCycle, KeepsTheTestBenchInputs) {
  AxisUnderTest axis;
  axis.write("test_load_torque", 1'000);
  axis.write("test_positive_limit_input", 1);
  axis.axis().power_cycle();
  EXPECT_EQ(axis.read("test_load_torque"), 1'000);
  EXPECT_EQ(axis.read("test_positive_limit_input"), 1);
  axis.step(100);
  EXPECT_GT(axis.velocity(), 0) << "the load still pulls";
  EXPECT_TRUE(axis.limit_active());
}

TEST(PowerCycle, LetsAMovingAxisCoast) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x003F);
  axis.step(300);
  const std::int32_t speed = axis.velocity();
  axis.axis().power_cycle();
  axis.step();
  EXPECT_NEAR(axis.velocity(), speed, 200);
  EXPECT_EQ(axis.statusword(), 0x0250);
}

TEST(PowerCycle, KeepsThePositionWithAGear) {
  AxisConfiguration configuration;
  configuration.parameters = {{object("gear_ratio_denominator"), 10}};
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.write("position_user_target_value", 5'000);
  axis.command(0x003F);
  axis.step(3'000);
  const std::int32_t load = axis.actual();
  const std::int32_t motor = axis.status().motor_position_actual_value;
  axis.axis().power_cycle();
  axis.step();
  EXPECT_EQ(axis.actual(), load);
  EXPECT_EQ(axis.status().motor_position_actual_value, motor);
}

TEST(PowerCycle, OfOneAxisDoesNotAffectOtherAxes) {
  AxisBank disturbed(mixed_axes(16), microseconds{1000});
  AxisBank quiet(mixed_axes(16), microseconds{1000});
  for (AxisBank* const bank : {&disturbed, &quiet}) {
    for (std::size_t axis = 0; axis < 16; ++axis) {
      bank->write(axis, object("op_mode_cmd"), 1);
      bank->write(axis, object("ds402_controlword"), 0x0F);
    }
    bank->step();
    for (std::size_t axis = 0; axis < 16; ++axis) {
      bank->write(axis, object("position_user_target_value"), 50'000);
      bank->write(axis, object("ds402_controlword"), 0x3F);
    }
    for (int i = 0; i < 100; ++i) bank->step();
  }
  disturbed.power_cycle(2);
  for (int i = 0; i < 500; ++i) {
    disturbed.step();
    quiet.step();
    for (std::size_t axis = 0; axis < 16; ++axis) {
      if (axis != 2) {
        ASSERT_EQ(disturbed.status(axis).load_position_actual_value,
                  quiet.status(axis).load_position_actual_value);
      }
    }
  }
}

// ---- periods -----------------------------------------------------------------------------------

class Period : public testing::TestWithParam<std::int64_t> {};

TEST_P(Period, RunsTheManualsExampleToTheExactUnitInTheSameDriveTime) {
  const microseconds period{GetParam()};
  AxisUnderTest axis({}, period);
  axis.enable();
  axis.write("profile_velocity", 1'000);
  axis.write("profile_acc", 6'000);
  axis.write("profile_dec", 6'000);
  axis.write("position_user_target_value", 10'000);
  EXPECT_EQ(axis.command(0x003F), 0x1237);
  const std::uint64_t begin = axis.ticks() - 1;
  ASSERT_NE(axis.step_until_reached(200'000), 0U);

  // 61/6 s, rounded up to whole ticks.
  const double ticks = std::ceil(61.0 / 6.0 / axis.seconds_per_tick());
  EXPECT_EQ(static_cast<double>(axis.ticks() - begin), ticks);
  EXPECT_EQ(axis.demand(), 10'000);
  axis.step_for(microseconds{200'000});
  EXPECT_EQ(axis.actual(), 10'000);
}

INSTANTIATE_TEST_SUITE_P(AxisBank, Period,
                         testing::Values(125, 126, 250, 333, 500, 1000, 2000, 4000, 9999, 10000),
                         testing::PrintToStringParamName());

TEST(AxisBank, TimesInMillisecondsHoldAtEveryPeriod) {
  for (const std::int64_t period : {125, 333, 1000, 4000, 10000}) {
    AxisUnderTest axis({}, microseconds{period});
    axis.enable();
    axis.command(0x003F);  // zero length: bit 10 after 6068h = 20 ms
    const std::uint64_t ticks = axis.step_until_reached(1'000);
    const double time = static_cast<double>(ticks) * axis.seconds_per_tick();
    EXPECT_GE(time, 0.020 - 1e-9) << period;
    EXPECT_LE(time, 0.020 + 1.01 * axis.seconds_per_tick()) << period;
  }
}

// ---- refused configurations --------------------------------------------------------------------

std::string refusal_of(const std::vector<AxisConfiguration>& axes, microseconds period) {
  try {
    const AxisBank bank(axes, period);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(InvalidConfiguration, WithoutAnAxisIsRefused) {
  EXPECT_THAT(refusal_of({}, microseconds{1000}), testing::HasSubstr("at least one axis"));
}

TEST(InvalidConfiguration, APeriodOutsideItsRangeIsNamedWithValueAndLimits) {
  for (const std::int64_t period : {-1000, 0, 124, 10001}) {
    const std::string message = refusal_of(std::vector<AxisConfiguration>(1), microseconds{period});
    EXPECT_THAT(message, testing::HasSubstr("period"));
    EXPECT_THAT(message, testing::HasSubstr(std::to_string(period)));
    EXPECT_THAT(message, testing::HasSubstr("125"));
    EXPECT_THAT(message, testing::HasSubstr("10000"));
  }
  EXPECT_EQ(refusal_of(std::vector<AxisConfiguration>(1), microseconds{125}), "");
  EXPECT_EQ(refusal_of(std::vector<AxisConfiguration>(1), microseconds{10000}), "");
}

struct ParameterRow {
  const char* name;
  double AxisModel::*member;
  const char* unit;
  bool zero_allowed;
};

TEST(InvalidConfiguration, AModelParameterOutsideItsRangeIsNamedWithValueUnitAndLimit) {
  const std::array<ParameterRow, 13> rows{{
      {"motor_inertia", &AxisModel::motor_inertia, "kg.m", false},
      {"load_inertia", &AxisModel::load_inertia, "kg.m", true},
      {"viscous_friction", &AxisModel::viscous_friction, "N.m.s/rad", true},
      {"coulomb_friction", &AxisModel::coulomb_friction, "N.m", true},
      {"load_viscous_friction", &AxisModel::load_viscous_friction, "N.m.s/rad", true},
      {"load_coulomb_friction", &AxisModel::load_coulomb_friction, "N.m", true},
      {"torque_constant", &AxisModel::torque_constant, "N.m/A", false},
      {"coupling_stiffness", &AxisModel::coupling_stiffness, "N.m/rad", false},
      {"coupling_damping", &AxisModel::coupling_damping, "N.m.s/rad", true},
      {"backlash", &AxisModel::backlash, "rad", true},
      {"current_loop_bandwidth", &AxisModel::current_loop_bandwidth, "Hz", false},
      {"velocity_loop_bandwidth", &AxisModel::velocity_loop_bandwidth, "Hz", false},
      {"position_loop_bandwidth", &AxisModel::position_loop_bandwidth, "Hz", false},
  }};
  for (const ParameterRow& row : rows) {
    SCOPED_TRACE(row.name);
    for (const double value : {-1.0, std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()}) {
      std::vector<AxisConfiguration> axes(2);
      axes[1].model.*row.member = value;
      const std::string message = refusal_of(axes, microseconds{1000});
      EXPECT_THAT(message, testing::HasSubstr(row.name));
      EXPECT_THAT(message, testing::HasSubstr(row.unit));
    }
    std::vector<AxisConfiguration> axes(1);
    axes[0].model.*row.member = 0.0;
    EXPECT_EQ(refusal_of(axes, microseconds{1000}).empty(), row.zero_allowed);
  }
}

TEST(InvalidConfiguration, AnElasticAxisNeedsALoad) {
  std::vector<AxisConfiguration> axes(1);
  axes[0].model.coupling = Coupling::two_inertia;
  axes[0].model.load_inertia = 0.0;
  EXPECT_THAT(refusal_of(axes, microseconds{1000}), testing::HasSubstr("load_inertia"));
}

TEST(InvalidConfiguration, AnEncoderCoarserThanTheUserUnitIsRefused) {
  std::vector<AxisConfiguration> axes(1);
  axes[0].model.encoder_resolution = 4095.0;
  EXPECT_THAT(refusal_of(axes, microseconds{1000}), testing::HasSubstr("encoder_resolution"));
  axes[0].model.encoder_resolution = 4096.0;
  EXPECT_EQ(refusal_of(axes, microseconds{1000}), "");
  axes[0].model.load_encoder_resolution = 1.0;
  EXPECT_THAT(refusal_of(axes, microseconds{1000}), testing::HasSubstr("load_encoder_resolution"));
}

TEST(InvalidConfiguration, AnInitialValueThatTheDictionaryRefusesIsRefused) {
  struct Row {
    ObjectAddress address;
    std::int64_t value;
  };

  for (const Row& row : {Row{{0x2000, 0}, 0}, Row{{0x6041, 0}, 0}, Row{{0x6080, 0}, 0},
                         Row{{0x6081, 1}, 0}, Row{{0x60F2, 0}, 3}, Row{{0x6060, 0}, 5}}) {
    std::vector<AxisConfiguration> axes(1);
    axes[0].parameters = {{row.address, row.value}};
    EXPECT_NE(refusal_of(axes, microseconds{1000}), "")
        << std::hex << row.address.index << " = " << row.value;
  }
}

TEST(InvalidConfiguration, AnInitialControlwordIsRefused) {
  std::vector<AxisConfiguration> axes(1);
  axes[0].parameters = {{{0x6040, 0}, 0x000F}};
  EXPECT_THAT(refusal_of(axes, microseconds{1000}), testing::HasSubstr("6040"));
}

TEST(InvalidConfiguration, TheFirstOfSeveralRefusedInitialValuesIsNamed) {
  std::vector<AxisConfiguration> axes(1);
  axes[0].parameters = {{{0x6081, 0}, 1'000}, {{0x6080, 0}, 0}, {{0x6041, 0}, 0}};
  EXPECT_THAT(refusal_of(axes, microseconds{1000}), testing::HasSubstr("6080"));
}

}  // namespace
}  // namespace vdrive
