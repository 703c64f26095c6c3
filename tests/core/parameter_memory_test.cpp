// SPDX-License-Identifier: Apache-2.0
// The parameters that an axis keeps over a power cycle, and its reaction when its memory fails:
// 1010h, 1011h, 5530h.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

constexpr std::chrono::milliseconds kPeriod{1};
constexpr ObjectAddress kStoreParameters{0x1010, 1};
constexpr ObjectAddress kRestoreParameters{0x1011, 1};
constexpr ObjectAddress kProfileVelocity{0x6081, 0};
constexpr ObjectAddress kLowerLimit{0x607D, 1};
constexpr ObjectAddress kGearNumerator{0x3576, 0};
constexpr ObjectAddress kTarget{0x607A, 0};
constexpr ObjectAddress kMode{0x6060, 0};
constexpr std::int64_t kSave = 0x65766173;  // CiA 301: "s", "a", "v", "e", lowest byte first
constexpr std::int64_t kLoad = 0x64616F6C;

AxisBank bank_of(const std::vector<AxisConfiguration>& axes) {
  return {axes, kPeriod};
}

std::int64_t value(const AxisBank& bank, ObjectAddress object, std::size_t axis = 0) {
  return bank.read(axis, object).value;
}

TEST(StoreParameters, Reads1AndAcceptsOnlyItsSignature) {
  for (const auto& [object, signature, other] :
       {std::tuple{kStoreParameters, kSave, kLoad}, {kRestoreParameters, kLoad, kSave}}) {
    AxisUnderTest axis;
    EXPECT_EQ(axis.axis().read(object).value, 1) << "saves on command";
    EXPECT_EQ(axis.axis().write(object, signature), AbortCode::none);
    EXPECT_EQ(axis.axis().read(object).value, 1);
    for (const std::int64_t wrong : {std::int64_t{0}, std::int64_t{1}, other, signature + 1,
                                     std::int64_t{0x73617665}, std::int64_t{0xFFFFFFFF}}) {
      EXPECT_EQ(axis.axis().write(object, wrong), AbortCode::cannot_store_or_transfer) << wrong;
    }
    EXPECT_EQ(axis.axis().write(object, 0x1'0000'0000), AbortCode::value_too_high);
    EXPECT_EQ(axis.axis().write(object, -1), AbortCode::value_too_low);
  }
}

TEST(StoreParameters, HaveOneSubIndexEach) {
  AxisUnderTest axis;
  EXPECT_EQ(axis.axis().write({0x1010, 0}, kSave), AbortCode::subindex_does_not_exist);
  EXPECT_EQ(axis.axis().write({0x1011, 2}, kLoad), AbortCode::subindex_does_not_exist);
}

TEST(ParameterMemory, IsInForceFromTheNextPowerUp) {
  AxisBank bank = bank_of(std::vector<AxisConfiguration>(2));
  const std::int64_t before = value(bank, kProfileVelocity);
  EXPECT_EQ(bank.set_stored(1, kProfileVelocity, 4'321), AbortCode::none);
  bank.step();
  EXPECT_EQ(value(bank, kProfileVelocity, 1), before);
  bank.power_cycle(0);
  bank.power_cycle(1);
  EXPECT_EQ(value(bank, kProfileVelocity, 0), before) << "of the other axis nothing is stored";
  EXPECT_EQ(value(bank, kProfileVelocity, 1), 4'321);
  bank.power_cycle(1);
  EXPECT_EQ(value(bank, kProfileVelocity, 1), 4'321);
}

TEST(ParameterMemory, OverridesTheConfiguredValues) {
  AxisConfiguration axis;
  axis.parameters = {{kProfileVelocity, 1'000}, {kLowerLimit, -500}};
  axis.stored = {{kProfileVelocity, 2'000}};
  AxisBank bank = bank_of({axis});
  EXPECT_EQ(value(bank, kProfileVelocity), 2'000);
  EXPECT_EQ(value(bank, kLowerLimit), -500) << "not stored";
  EXPECT_EQ(bank.status(0).ds402_statusword, 0x0250) << "powered up as without a memory";
  bank.forget_stored(0);
  EXPECT_EQ(value(bank, kProfileVelocity), 2'000) << "1011h is in force after the next power cycle";
  bank.power_cycle(0);
  EXPECT_EQ(value(bank, kProfileVelocity), 1'000);
}

TEST(ParameterMemory, ActsLikeAWriteOfItsValues) {
  AxisConfiguration axis;
  axis.stored = {
      {kGearNumerator, 3}, {kLowerLimit, -1'000}, {{0x607D, 2}, 1'000}, {{0x3535, 0}, 1}};
  axis.initial_position = 1'500;
  AxisBank stored = bank_of({axis});
  axis.stored.clear();
  AxisBank written = bank_of({axis});
  written.write(0, kGearNumerator, 3);
  written.write(0, kLowerLimit, -1'000);
  written.write(0, {0x607D, 2}, 1'000);
  written.write(0, {0x3535, 0}, 1);
  stored.step();
  written.step();
  EXPECT_NE(stored.status(0).ds402_statusword & Statusword::kInternalLimitActive, 0);
  EXPECT_EQ(stored.status_hash(), written.status_hash());
}

TEST(ParameterMemory, AcceptsStoredObjectsWithinTheirRange) {
  EXPECT_EQ(AxisBank::check_stored(kProfileVelocity, 5), AbortCode::none);
  EXPECT_EQ(AxisBank::check_stored(kTarget, 5), AbortCode::cannot_store_or_transfer);
  EXPECT_EQ(AxisBank::check_stored(kMode, 1), AbortCode::cannot_store_or_transfer);
  EXPECT_EQ(AxisBank::check_stored(kStoreParameters, kSave), AbortCode::cannot_store_or_transfer);
  EXPECT_EQ(AxisBank::check_stored({0x7000, 0}, 5), AbortCode::object_does_not_exist);
  EXPECT_EQ(AxisBank::check_stored({0x6081, 1}, 5), AbortCode::subindex_does_not_exist);
  EXPECT_EQ(AxisBank::check_stored(kProfileVelocity, -1), AbortCode::value_too_low);
  EXPECT_EQ(AxisBank::check_stored(kProfileVelocity, 0x1'0000'0000), AbortCode::value_too_high);
  EXPECT_EQ(AxisBank::check_stored({0x6098, 0}, 16), AbortCode::value_range_exceeded);
  EXPECT_EQ(AxisBank::check_stored({0x60F2, 0}, 3), AbortCode::value_range_exceeded);
  AxisBank bank = bank_of({{}});
  EXPECT_EQ(bank.set_stored(0, {0x60F2, 0}, 3), AbortCode::value_range_exceeded);
  bank.power_cycle(0);
  EXPECT_EQ(value(bank, {0x60F2, 0}), 2);
  AxisConfiguration bad;
  bad.stored = {{{0x60F2, 0}, 3}};
  EXPECT_THROW(bank_of({bad}), std::invalid_argument);
}

/// @return a value other than the default, if the object accepts one.
std::int64_t other_value(const ObjectDescription& object) {
  switch (object.address.index) {
    case 0x6086:  // 0 and 3
      return 3;
    case 0x6098:
      return 17;
    case 0x60C0:  // the only value
      return object.default_value;
    case 0x60C4:  // :03 and :05 accept one value only
      if (object.address.subindex == 3 || object.address.subindex == 5) return object.default_value;
      break;
    default:
      break;
  }
  return object.default_value == object.lower_limit ? object.lower_limit + 1 : object.lower_limit;
}

TEST(ParameterMemory, HoldsEveryObjectThatTheTableStores) {
  std::size_t count = 0;
  for (const ObjectDescription& row : kObjectTable) {
    if (row.storage != Storage::flash) continue;
    ++count;
    AxisBank bank = bank_of({{}});
    const std::int64_t other = other_value(row);
    ASSERT_EQ(bank.set_stored(0, row.address, other), AbortCode::none) << row.variable_name;
    bank.power_cycle(0);
    EXPECT_EQ(value(bank, row.address), other) << row.variable_name;
    std::vector<std::int64_t> now(kStoredRows.size());
    bank.read_parameters(0, now);
    for (std::size_t position = 0; position < kStoredRows.size(); ++position) {
      ASSERT_EQ(now[position], value(bank, describe(kStoredRows[position]).address));
    }
  }
  EXPECT_EQ(count, kStoredRows.size());
}

TEST(ParameterMemory, IsRestoredWithASnapshotUnlessItIsKept) {
  AxisBank bank = bank_of({{}});
  const AxisBank::Snapshot empty = bank.snapshot();
  bank.set_stored(0, kProfileVelocity, 77);
  bank.restore(empty, AxisBank::Memory::kept);
  bank.power_cycle(0);
  EXPECT_EQ(value(bank, kProfileVelocity), 77);
  AxisBank other = bank_of({{}});
  other.restore(other.snapshot_from(bank.snapshot().bytes()));
  other.write(0, kProfileVelocity, 5);
  other.power_cycle(0);
  EXPECT_EQ(value(other, kProfileVelocity), 77) << "the bytes carry it";
  bank.restore(empty);
  bank.power_cycle(0);
  EXPECT_NE(value(bank, kProfileVelocity), 77);
}

AxisConfiguration axis_with_memory_error() {
  AxisConfiguration axis;
  axis.memory_error = true;
  return axis;
}

TEST(ParameterMemoryError, IsAFaultAfterPowerUpThatAResetEnds) {
  AxisUnderTest axis(axis_with_memory_error());
  EXPECT_EQ(axis.state(), fault_reaction_active);
  axis.step(2);
  EXPECT_EQ(axis.statusword(), 0x0218);
  EXPECT_EQ(axis.read("error_code"), 0x5530);
  EXPECT_EQ(axis.read("error_register"), 1);
  EXPECT_EQ(axis.read("error_history_1") & 0xFFFF, 0x5530);
  EXPECT_EQ(axis.status().fault_count, 1U);
  axis.enable();
  EXPECT_EQ(axis.state(), fault) << "latched";
  axis.command(0x0080);
  EXPECT_EQ(axis.state(), switch_on_disabled);
  EXPECT_EQ(axis.read("error_code"), 0);
  axis.enable();
  EXPECT_EQ(axis.state(), operation_enabled);
}

TEST(ParameterMemoryError, ReturnsAtEachPowerUpUntilParametersAreStored) {
  AxisUnderTest axis(axis_with_memory_error());
  axis.step(2);
  axis.command(0x0080);
  axis.axis().power_cycle();
  EXPECT_EQ(axis.state(), not_ready_to_switch_on);
  axis.step(2);
  EXPECT_EQ(axis.state(), fault);
  EXPECT_EQ(axis.read("error_code"), 0x5530);
  EXPECT_EQ(axis.status().fault_count, 1U);
  axis.axis().forget_stored();
  axis.axis().power_cycle();
  axis.step(2);
  EXPECT_EQ(axis.state(), switch_on_disabled);
}

TEST(ParameterMemoryError, AffectsItsAxisOnly) {
  std::vector<AxisConfiguration> axes(3);
  axes[1].memory_error = true;
  AxisBank bank = bank_of(axes);
  bank.step();
  bank.step();
  EXPECT_EQ(bank.power_state(0), switch_on_disabled);
  EXPECT_EQ(bank.power_state(1), fault);
  EXPECT_EQ(bank.power_state(2), switch_on_disabled);
}

}  // namespace
}  // namespace vdrive
