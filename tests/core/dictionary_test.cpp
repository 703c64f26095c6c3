// SPDX-License-Identifier: Apache-2.0
// The object table against the manual's table and the companion table, and each access with its
// abort code.
#include "vdrive/dictionary/dictionary.hpp"

#include "core/support/axis_under_test.hpp"
#include "core/support/csv.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/dictionary/standard_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <iomanip>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using test::CsvRow;
using test::read_csv;

const std::string kData = VDRIVE_SOURCE_DIR "/tests/data/";

// The file to change when a row of the table differs from another file.
constexpr std::string_view kTable = "core/include/vdrive/dictionary/object_table.hpp";
constexpr std::string_view kManualCsv = "tests/data/object-dictionary.csv";
constexpr std::string_view kCompanionCsv = "tests/data/companion-objects.csv";

/// Modes that 6060h accepts; bit n - 1 of 6502h stands for mode n: pp, vl, pv, tq, hm, ip, csp,
/// csv, cst.
const std::set<std::int64_t> kWorkingModes{0, 1, 2, 3, 4, 6, 7, 8, 9, 10};
constexpr std::int64_t kModeBits = 0b11'1110'1111;

ObjectAddress address_of(const CsvRow& row) {
  return {static_cast<std::uint16_t>(std::stoul(row.at("index"), nullptr, 16)),
          static_cast<std::uint8_t>(std::stoul(row.at("subindex"), nullptr, 16))};
}

std::string show(ObjectAddress address) {
  std::ostringstream text;
  text << std::hex << std::uppercase << std::setfill('0') << std::setw(4) << address.index
       << "h:" << std::setw(2) << static_cast<unsigned>(address.subindex);
  return text.str();
}

void expect_common_cells(const ObjectDescription& object, const CsvRow& row) {
  EXPECT_EQ(object.name, row.at("name"));
  EXPECT_EQ(object.variable_name, row.at("variable_name"));
  EXPECT_EQ(object.access == Access::read_write ? "RW" : "RO", row.at("access"));
  EXPECT_EQ(object.storage == Storage::flash ? "Y" : "N", row.at("store_in_flash"));
  EXPECT_EQ(to_string(object.data_type), row.at("data_type"));
  EXPECT_EQ(object.lower_limit, std::stoll(row.at("lower_limit")));
  EXPECT_EQ(object.upper_limit, std::stoll(row.at("upper_limit")));
  // 6502h shows the supported modes; the CSV tables list those of the first version.
  EXPECT_EQ(object.default_value,
            object.address.index == 0x6502 ? kModeBits : std::stoll(row.at("default_value")));
  EXPECT_EQ(object.units, row.at("units"));
}

TEST(ObjectTable, HoldsEveryCellOfTheManualsTable) {
  const std::vector<CsvRow> rows = read_csv(kData + "object-dictionary.csv");
  ASSERT_EQ(rows.size(), 32U);
  for (const CsvRow& row : rows) {
    SCOPED_TRACE(row.at("index") + ":" + row.at("subindex") + " of " + std::string(kManualCsv) +
                 " and of " + std::string(kTable));
    const auto found = find_object(address_of(row));
    ASSERT_TRUE(found.has_value()) << "the object has no row in " << kTable;
    const ObjectDescription& object = describe(*found);

    expect_common_cells(object, row);
    EXPECT_EQ(object.name_zh, row.at("name_zh"));
    EXPECT_EQ(object.category, row.at("category"));
    EXPECT_EQ(object.origin, Origin::manual);
    // The manual distinguishes only "immediately" and "read only"; its notes on 607Ah, 607Fh,
    // 6080h, 6081h and 60F2h are more specific.
    EXPECT_EQ(object.effective == Effective::read_only ? "只读" : "立即", row.at("effective"));
  }
}

TEST(ObjectTable, HoldsEveryCellOfTheCompanionTable) {
  for (const CsvRow& row : read_csv(kData + "companion-objects.csv")) {
    SCOPED_TRACE(row.at("index") + ":" + row.at("subindex") + " of " + std::string(kCompanionCsv) +
                 " and of " + std::string(kTable));
    const ObjectAddress address = address_of(row);
    const auto found = find_object(address);
    ASSERT_TRUE(found.has_value()) << "the object has no row in " << kTable;
    const ObjectDescription& object = describe(*found);
    expect_common_cells(object, row);
    EXPECT_EQ(object.origin, Origin::companion);
    EXPECT_FALSE(object.name_zh.empty());
    EXPECT_FALSE(object.category.empty());
    EXPECT_EQ(object.effective == Effective::read_only, object.access == Access::read_only);
  }
}

TEST(ObjectTable, HasOnlyRowsOfTheTwoTables) {
  std::set<ObjectAddress> named;
  for (const char* const file : {"object-dictionary.csv", "companion-objects.csv"}) {
    for (const CsvRow& row : read_csv(kData + file)) named.insert(address_of(row));
  }
  for (const ObjectDescription& object : kObjectTable) {
    EXPECT_TRUE(named.contains(object.address))
        << show(object.address) << " " << object.variable_name << " of " << kTable
        << " has no row in " << kCompanionCsv;
  }
}

TEST(AddressSuggestion, IsOfferedForFourHexDigits) {
  EXPECT_EQ(address_suggestion("6041"), " (did you mean 0x6041 or 6041h?)");
  EXPECT_EQ(address_suggestion("607D:1"), " (did you mean 0x607D:1 or 607Dh:1?)");
  for (const char* const text : {"", "604", "60410", "0x6041", "6041h", "607D:", "60x1", "9999"}) {
    EXPECT_EQ(address_suggestion(text), "") << text;
  }
}

/// FNV-1a over the object descriptions that clients have.
std::uint32_t dictionary_check() {
  constexpr std::uint32_t kOffset = 2166136261U;
  constexpr std::uint32_t kPrime = 16777619U;
  std::uint32_t check = kOffset;
  for (const ObjectDescription& object : kObjectTable) {
    std::ostringstream row;
    row << address_text(object.address) << ' ' << object.variable_name << ' '
        << to_string(object.data_type) << ' ' << (object.access == Access::read_write ? "RW" : "RO")
        << ' ' << object.lower_limit << ' ' << object.upper_limit << '\n';
    for (const char c : row.str()) check = (check ^ static_cast<std::uint8_t>(c)) * kPrime;
  }
  return check;
}

TEST(ObjectTable, HasANewVersionWhenItsRowsChange) {
  constexpr std::string_view kVersion = "1.5";
  constexpr std::uint32_t kCheck = 0x96361346;  // of the rows of that version
  EXPECT_EQ(kDictionaryVersion, kVersion);
  EXPECT_EQ(dictionary_check(), kCheck)
      << "the rows of " << kTable
      << " have changed: its kDictionaryVersion needs the next version, "
      << "and this test of tests/core/dictionary_test.cpp that version and the check "
      << dictionary_check();
}

TEST(ObjectTable, GivesTheMomentOfEffectFromTheManualsMoreSpecificNotes) {
  using namespace literals;
  // 607Ah and 6081h: "bit 4 has to go from 0 to 1 before they take effect"; 607Fh: "only after
  // disabling and enabling again"; 6080h bounds 607Fh and takes effect with it.
  EXPECT_EQ(describe("position_user_target_value"_object).effective, Effective::at_set_point);
  EXPECT_EQ(describe("profile_velocity"_object).effective, Effective::at_set_point);
  EXPECT_EQ(describe("positioning_option_code"_object).effective, Effective::at_set_point);
  EXPECT_EQ(describe("app_speed_limit"_object).effective, Effective::at_enable);
  EXPECT_EQ(describe("motor_max_speed_rpm"_object).effective, Effective::at_enable);
  // 6083h and 6084h: "can be changed in motion, in effect immediately".
  EXPECT_EQ(describe("profile_acc"_object).effective, Effective::immediately);
  EXPECT_EQ(describe("profile_dec"_object).effective, Effective::immediately);
}

// docs/reference/wire.md: a write to one of the ten command objects acquires a free axis; any
// session may write 5E00h to 5E0Ch, 5E20h and 5E21h.
TEST(ObjectTable, MarksTheCommandObjectsAndTheTestInputs) {
  std::vector<ObjectAddress> commands;
  std::size_t test_inputs = 0;
  for (const ObjectDescription& object : kObjectTable) {
    const std::uint16_t index = object.address.index;
    const bool is_beside = index == 0x5E20 || index == 0x5E21;  // habits, places of switches
    EXPECT_EQ(object.role == Role::test_input, is_beside || (index >= 0x5E00 && index <= 0x5E0C))
        << show(object.address);
    test_inputs += object.role == Role::test_input ? 1U : 0U;
    if (object.role == Role::command) commands.push_back(object.address);
  }
  EXPECT_EQ(commands, (std::vector<ObjectAddress>{{0x6040, 0},
                                                  {0x6042, 0},
                                                  {0x6060, 0},
                                                  {0x6071, 0},
                                                  {0x607A, 0},
                                                  {0x60B0, 0},
                                                  {0x60B1, 0},
                                                  {0x60B2, 0},
                                                  {0x60C1, 1},
                                                  {0x60FF, 0}}));
  EXPECT_EQ(test_inputs, 33U);
  EXPECT_FALSE(has_role({0x6040, 1}, Role::command)) << "no such object";
}

TEST(ObjectTable, MarksObjectsThatChangeTargetModeOrPowerAsCommands) {
  constexpr std::array kCommanding{Change::power, Change::mode, Change::target,
                                   Change::planned_target, Change::record};
  for (const ObjectDescription& object : kObjectTable) {
    EXPECT_EQ(std::ranges::find(kCommanding, object.change) != kCommanding.end(),
              object.role == Role::command)
        << show(object.address);
    if (object.access == Access::read_only) {
      EXPECT_EQ(object.change, Change::limits) << show(object.address) << " is never written";
    }
    if (object.effective == Effective::at_set_point && object.origin == Origin::manual) {
      EXPECT_TRUE(object.change == Change::nothing || object.change == Change::target)
          << show(object.address) << " waits for the set-point";
    }
  }
}

TEST(ObjectTable, HasUnitsInEnglish) {
  using namespace literals;
  for (const ObjectDescription& object : kObjectTable) {
    const std::string units = english_units(object);
    EXPECT_FALSE(units.empty()) << show(object.address);
    // The per-mille sign is the only character outside ASCII.
    std::string ascii = units;
    if (const std::size_t found = ascii.find("‰"); found != std::string::npos) {
      ascii.erase(found, std::string_view("‰").size());
    }
    EXPECT_TRUE(std::ranges::all_of(ascii,
                                    [](char c) {
                                      return c > 0;
                                    }))
        << show(object.address) << ": " << units;
  }
  EXPECT_EQ(english_units(describe("profile_velocity"_object)), "VelUU");
  EXPECT_EQ(english_units(describe("current_error_value"_object)), "TqCU (mA)");
  EXPECT_EQ(english_units(describe("positive_torque_limit_relative"_object)), "0.1%");
}

TEST(ObjectTable, RowsAreConsistent) {
  std::set<std::string_view> names;
  for (const ObjectDescription& object : kObjectTable) {
    SCOPED_TRACE(show(object.address));
    const TypeRange range = range_of(object.data_type);
    EXPECT_GE(object.lower_limit, range.lowest);
    EXPECT_LE(object.upper_limit, range.highest);
    EXPECT_LE(object.lower_limit, object.default_value);
    EXPECT_LE(object.default_value, object.upper_limit);
    EXPECT_TRUE(names.insert(object.variable_name).second) << "variable_name used twice";
  }
}

TEST(ObjectTable, IsFoundByAddressAndByName) {
  for (std::size_t i = 0; i < kObjectTable.size(); ++i) {
    const ObjectDescription& object = kObjectTable[i];
    EXPECT_EQ(find_object(object.address), std::optional<ObjectRow>(i));
    EXPECT_EQ(find_object(object.variable_name), std::optional<ObjectRow>(i));
    EXPECT_EQ(check_address(object.address), AbortCode::none);
  }
  EXPECT_EQ(find_object("no_such_object"), std::nullopt);
  EXPECT_EQ(find_object(""), std::nullopt);
}

TEST(ObjectTable, DataTypesHaveTheSizesAndRangesOfCiA301) {
  EXPECT_EQ(size_of(DataType::integer8), 1);
  EXPECT_EQ(size_of(DataType::integer16), 2);
  EXPECT_EQ(size_of(DataType::integer32), 4);
  EXPECT_EQ(size_of(DataType::unsigned8), 1);
  EXPECT_EQ(size_of(DataType::unsigned16), 2);
  EXPECT_EQ(size_of(DataType::unsigned32), 4);
  EXPECT_EQ(range_of(DataType::integer8).lowest, -128);
  EXPECT_EQ(range_of(DataType::integer8).highest, 127);
  EXPECT_EQ(range_of(DataType::integer16).lowest, -32768);
  EXPECT_EQ(range_of(DataType::integer16).highest, 32767);
  EXPECT_EQ(range_of(DataType::integer32).lowest, -2147483648LL);
  EXPECT_EQ(range_of(DataType::integer32).highest, 2147483647LL);
  EXPECT_EQ(range_of(DataType::unsigned8).highest, 255);
  EXPECT_EQ(range_of(DataType::unsigned16).highest, 65535);
  EXPECT_EQ(range_of(DataType::unsigned32).highest, 4294967295LL);
  EXPECT_EQ(range_of(DataType::unsigned32).lowest, 0);
}

TEST(ObjectAddressCheck, NamesTheMissingPartOfEveryUnknownAddress) {
  std::set<std::uint16_t> indexes;
  for (const ObjectDescription& object : kObjectTable) indexes.insert(object.address.index);
  for (std::uint32_t index = 0; index <= 0xFFFF; ++index) {
    const bool exists = indexes.contains(static_cast<std::uint16_t>(index));
    for (const unsigned subindex : {0U, 1U, 2U, 4U, 8U, 9U, 255U}) {
      const ObjectAddress address{static_cast<std::uint16_t>(index),
                                  static_cast<std::uint8_t>(subindex)};
      if (!exists) {
        ASSERT_EQ(check_address(address), AbortCode::object_does_not_exist) << show(address);
      } else if (!find_object(address)) {
        ASSERT_EQ(check_address(address), AbortCode::subindex_does_not_exist) << show(address);
      }
    }
  }
}

// ---- each object x {below, lowest, default, highest, above, outside the type} x {read, write} --

/// 0, the methods of CiA 402-2 (15, 16, 31 and 32 are reserved), and those that search for a
/// mechanical stop.
const std::set<std::int64_t> kHomingMethods{-4, -3, -2, -1, 0,  1,  2,  3,  4,  5,  6,  7,  8,
                                            9,  10, 11, 12, 13, 14, 17, 18, 19, 20, 21, 22, 23,
                                            24, 25, 26, 27, 28, 29, 30, 33, 34, 35, 37};

/// @return the abort code that a write must get. Access is checked first, then the range of the row
///         (a value outside the type is also outside the row's range), then the narrower rules of
///         single objects.
AbortCode expected_answer(const ObjectDescription& object, std::int64_t value) {
  if (object.access == Access::read_only) return AbortCode::write_of_read_only_object;
  // For these four objects the meaning of a value decides, not the range of the row. 1003h:00:
  // "write 0 to sub 0 empties it; any other value is refused"; 6098h: "0 or a supported method".
  constexpr std::array<std::uint16_t, 4> kByMeaning{0x1003, 0x6086, 0x6098, 0x60A3};
  const bool by_meaning = std::ranges::find(kByMeaning, object.address.index) != kByMeaning.end();
  const TypeRange type = range_of(object.data_type);
  if (value > (by_meaning ? type.highest : object.upper_limit)) return AbortCode::value_too_high;
  if (value < (by_meaning ? type.lowest : object.lower_limit)) return AbortCode::value_too_low;
  switch (object.address.index) {
    case 0x6060:
      return kWorkingModes.contains(value) ? AbortCode::none : AbortCode::value_range_exceeded;
    case 0x6098:
      return kHomingMethods.contains(value) ? AbortCode::none : AbortCode::value_range_exceeded;
    case 0x6086:  // trapezoid or limited jerk
      return value == 0 || value == 3 ? AbortCode::none : AbortCode::value_range_exceeded;
    case 0x60A3:  // one jerk for both ramps, or one for each
      return value == 1 || value == 2 ? AbortCode::none : AbortCode::value_range_exceeded;
    case 0x60C0:  // linear
      return value == 0 ? AbortCode::none : AbortCode::value_range_exceeded;
    case 0x60C4: {  // first in, first out; records of 4 bytes
      const std::uint8_t subindex = object.address.subindex;
      const bool is_refused = (subindex == 3 && value != 0) || (subindex == 5 && value != 4);
      return is_refused ? AbortCode::value_range_exceeded : AbortCode::none;
    }
    case 0x60B8: {  // CiA 402-2: bits 6, 7, 14, 15 are manufacturer-specific; source 3 is reserved
      const bool has_meaning =
          (value & 0xC0C0) == 0 && (value & 0x000C) != 0x000C && (value & 0x0C00) != 0x0C00;
      return has_meaning ? AbortCode::none : AbortCode::value_range_exceeded;
    }
    case 0x60D0:  // three inputs, and the index pulse: 5
      return value != 4 ? AbortCode::none : AbortCode::value_range_exceeded;
    case 0x60F2:  // relative options 0 to 2
      return value <= 2 ? AbortCode::none : AbortCode::value_range_exceeded;
    case 0x5E20:  // :0C, bits 9, 14 and 15 of the statusword
      return object.address.subindex != 0x0C || (value & ~0xC200) == 0
                 ? AbortCode::none
                 : AbortCode::value_range_exceeded;
    case 0x1003:  // only 0 empties the history
      return value == 0 ? AbortCode::none : AbortCode::value_range_exceeded;
    case 0x1010:  // accept only "save" and "load", which the sweep does not write
    case 0x1011:
      return AbortCode::cannot_store_or_transfer;
    default:
      return AbortCode::none;
  }
}

std::vector<std::int64_t> sweep_of(const ObjectDescription& object) {
  const TypeRange type = range_of(object.data_type);
  return {std::numeric_limits<std::int64_t>::min(),
          type.lowest - 1,
          type.lowest,
          object.lower_limit - 1,
          object.lower_limit,
          object.lower_limit + 1,
          object.default_value,
          object.upper_limit - 1,
          object.upper_limit,
          object.upper_limit + 1,
          type.highest,
          type.highest + 1,
          std::numeric_limits<std::int64_t>::max()};
}

TEST(DictionarySweep, EveryValueIsAcceptedAndReadBackOrRefusedWithItsAbortCode) {
  for (const ObjectDescription& object : kObjectTable) {
    for (const std::int64_t value : sweep_of(object)) {
      SCOPED_TRACE(show(object.address) + " = " + std::to_string(value));
      AxisUnderTest axis;
      const ReadResult before = axis.axis().read(object.address);

      const AbortCode code = axis.axis().write(object.address, value);

      ASSERT_EQ(code, expected_answer(object, value)) << describe(code);
      const ReadResult after = axis.axis().read(object.address);
      const bool stays = code != AbortCode::none || object.address.index == 0x1003;
      EXPECT_EQ(after.value, stays ? before.value : value);
    }
  }
}

TEST(DictionarySweep, AWrongSubIndexHasItsOwnAbortCodeForReadAndWrite) {
  AxisUnderTest axis;
  for (const ObjectDescription& object : kObjectTable) {
    for (const unsigned subindex : {0U, 1U, 2U, 3U, 9U, 255U}) {
      const ObjectAddress address{object.address.index, static_cast<std::uint8_t>(subindex)};
      if (find_object(address)) continue;
      EXPECT_EQ(axis.axis().write(address, 0), AbortCode::subindex_does_not_exist) << show(address);
      EXPECT_EQ(axis.axis().read(address).code, AbortCode::subindex_does_not_exist)
          << show(address);
      EXPECT_EQ(axis.axis().read(address).value, 0);
    }
  }
}

TEST(DictionarySweep, AnUnknownIndexHasItsOwnAbortCodeForReadAndWrite) {
  AxisUnderTest axis;
  for (const unsigned index : {0x0000U, 0x0FFFU, 0x2000U, 0x6045U, 0x60F8U, 0xFFFFU}) {
    const ObjectAddress address{static_cast<std::uint16_t>(index), 0};
    EXPECT_EQ(axis.axis().write(address, 0), AbortCode::object_does_not_exist);
    EXPECT_EQ(axis.axis().read(address).code, AbortCode::object_does_not_exist);
  }
}

TEST(DictionarySweep, ChecksIndexThenSubIndexThenAccessThenRange) {
  AxisUnderTest axis;
  constexpr std::int64_t kFarOut = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(axis.axis().write({0x2000, 7}, kFarOut), AbortCode::object_does_not_exist);
  EXPECT_EQ(axis.axis().write({0x6041, 7}, kFarOut), AbortCode::subindex_does_not_exist);
  EXPECT_EQ(axis.axis().write({0x6041, 0}, kFarOut), AbortCode::write_of_read_only_object);
  EXPECT_EQ(axis.axis().write({0x6060, 0}, kFarOut), AbortCode::value_too_high);
}

TEST(DictionarySweep, GivesTheAbortCodesOfTheSpecification) {
  AxisUnderTest axis;
  // "6080h = 0 -> 0x06090032"; "write to 6041h/6061h/6062h/6064h -> 0x06010002".
  EXPECT_EQ(axis.try_write("motor_max_speed_rpm", 0), AbortCode{0x06090032});
  for (const char* const name : {"ds402_statusword", "op_mode_actual", "position_demand_value",
                                 "load_position_actual_value"}) {
    EXPECT_EQ(axis.try_write(name, 0), AbortCode{0x06010002}) << name;
  }
  // Reading an empty entry of the history: 0x08000024.
  EXPECT_EQ(axis.try_read("error_history_1").code, AbortCode{0x08000024});
  EXPECT_EQ(axis.try_read("error_history_8").code, AbortCode{0x08000024});
}

TEST(PowerUp, EveryObjectHasItsDefault) {
  AxisUnderTest axis;
  for (const ObjectDescription& object : kObjectTable) {
    SCOPED_TRACE(show(object.address));
    const ReadResult result = axis.axis().read(object.address);
    if (object.address.index == 0x1003 && object.address.subindex > 0) {
      EXPECT_EQ(result.code, AbortCode::no_data_available);
      continue;
    }
    ASSERT_EQ(result.code, AbortCode::none);
    // The statusword of Switch on disabled is the manual's 0x250.
    EXPECT_EQ(result.value, object.address.index == 0x6041 ? 0x250 : object.default_value);
  }
}

TEST(PowerUp, TakesTheInitialValuesOfTheConfiguration) {
  AxisConfiguration configuration;
  configuration.initial_position = -12345;
  configuration.serial_number = 65537;
  configuration.parameters = {{{0x6081, 0}, 1000}, {{0x607D, 1}, -5}};
  const AxisUnderTest axis(configuration);
  EXPECT_EQ(axis.read("profile_velocity"), 1000);
  EXPECT_EQ(axis.read("user_position_lower_limit"), -5);
  EXPECT_EQ(axis.read("serial_number"), 65537);
  EXPECT_EQ(axis.read("load_position_actual_value"), -12345);
  EXPECT_EQ(axis.read("position_demand_value"), -12345);
  EXPECT_EQ(axis.read("motor_position_actual_value"), -12345);
}

TEST(PowerUp, TakesTheIdentityOfTheConfigurationWhichNobodyWrites) {
  AxisConfiguration configuration;
  configuration.serial_number = 65537;
  configuration.parameters = {
      {{0x1018, 1}, 0xFFFFFFFF}, {{0x1018, 2}, 77}, {{0x1018, 3}, 3}, {{0x1018, 4}, 5}};
  AxisUnderTest axis(configuration);
  for (int power_up = 0; power_up < 2; ++power_up) {
    EXPECT_EQ(axis.read("vendor_id"), 0xFFFFFFFF);
    EXPECT_EQ(axis.read("product_code"), 77);
    EXPECT_EQ(axis.read("revision_number"), 3);
    EXPECT_EQ(axis.read("serial_number"), 5) << "instead of that of the bench";
    axis.axis().power_cycle();
  }
  EXPECT_EQ(axis.try_write("vendor_id", 1), AbortCode::write_of_read_only_object);
}

TEST(PowerUp, RefusesAnInitialValueByTheAxisWhereThereAreSeveral) {
  const auto refusal_of = [](const std::vector<AxisConfiguration>& axes) {
    try {
      const AxisBank bank(axes, std::chrono::milliseconds(1));
    } catch (const std::invalid_argument& refusal) {
      return std::string(refusal.what());
    }
    return std::string("accepted");
  };
  AxisConfiguration bad;
  bad.parameters = {{{0x6098, 0}, 36}};
  const std::string refused = "initial value 36 of homing_method (6098h) is refused";
  EXPECT_EQ(refusal_of({bad}), refused);
  EXPECT_EQ(refusal_of({AxisConfiguration{}, bad}), "axis 1: " + refused);
}

TEST(Registers, ReadBackWritesAtOnceAndComputedObjectsOfTheLastTick) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 1);
  axis.controlword(0x000F);

  EXPECT_EQ(axis.read("op_mode_cmd"), 1);
  EXPECT_EQ(axis.read("ds402_controlword"), 0x000F);
  EXPECT_EQ(axis.read("op_mode_actual"), 0);
  EXPECT_EQ(axis.read("ds402_statusword"), 0x250);

  axis.step();
  EXPECT_EQ(axis.read("op_mode_actual"), 1);
  EXPECT_EQ(axis.read("ds402_statusword"), 0x637);
}

TEST(Registers, ReadAsTheStatusImageShows) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("position_user_target_value", 40000);
  axis.command(0x001F);
  axis.step(100);  // in the middle of the move
  const AxisStatus& status = axis.status();
  EXPECT_NE(status.velocity_demand_value, 0);
  EXPECT_EQ(axis.read("position_demand_value"), status.position_demand_value);
  EXPECT_EQ(axis.read("load_position_actual_value"), status.load_position_actual_value);
  EXPECT_EQ(axis.read("load_position_error_value"), status.load_position_error_value);
  EXPECT_EQ(axis.read("motor_position_actual_value"), status.motor_position_actual_value);
  EXPECT_EQ(axis.read("motor_position_error_value"), status.motor_position_error_value);
  EXPECT_EQ(axis.read("velocity_demand_value"), status.velocity_demand_value);
  EXPECT_EQ(axis.read("load_velocity_actual_value"), status.load_velocity_actual_value);
  EXPECT_EQ(axis.read("load_velocity_error_value"), status.load_velocity_error_value);
  EXPECT_EQ(axis.read("motor_velocity_actual_value"), status.motor_velocity_actual_value);
  EXPECT_EQ(axis.read("motor_velocity_error_value"), status.motor_velocity_error_value);
  EXPECT_EQ(axis.read("current_actual_value"), status.current_actual_value);
  EXPECT_EQ(axis.read("current_error_value"), status.current_error_value);
  EXPECT_EQ(axis.read("torque_actual_value"), status.torque_actual_value);
  EXPECT_EQ(axis.read("torque_demand"), status.torque_demand);
  EXPECT_EQ(axis.read("ds402_statusword"), status.ds402_statusword);
  EXPECT_EQ(axis.read("ds402_controlword"), status.ds402_controlword);
  EXPECT_EQ(axis.read("op_mode_actual"), status.op_mode_actual);
  EXPECT_EQ(axis.read("motor_op_status"), status.motor_op_status);
  EXPECT_EQ(axis.read("error_code"), status.error_code);
  EXPECT_EQ(axis.read("error_register"), status.error_register);
  EXPECT_EQ(axis.read("digital_inputs"), status.digital_inputs);
}

TEST(ObjectText, NamesAnObjectAsTheDictionaryAndTheStandardDo) {
  EXPECT_EQ(object_text({0x6081, 0}), "profile_velocity (6081h)");
  EXPECT_EQ(object_text({0x607D, 2}), "user_position_upper_limit (607Dh:2)");
  EXPECT_EQ(object_text({0x5FFF, 0}), "object (5FFFh)");
  EXPECT_EQ(index_text(0x0FFF), "0FFFh");
}

TEST(ValuesOfAnObject, AreListedWhereTheyAreFew) {
  const auto text_of = [](std::string_view name) {
    return values_text(*find_object(name));
  };
  // Modes that 6502h shows, and 0; the drive's methods, and 0; the manual's option codes.
  EXPECT_EQ(text_of("op_mode_cmd"), "0, 1, 2, 3, 4, 6, 7, 8, 9 or 10");
  EXPECT_EQ(text_of("homing_method"), "-4 to 14, 17 to 30, 33 to 35 or 37");
  EXPECT_EQ(text_of("positioning_option_code"), "0, 1 or 2");
  EXPECT_EQ(text_of("error_history_count"), "0");
  EXPECT_EQ(text_of("halt_option_code"), "1 to 4") << "every value of its range";
  EXPECT_EQ(text_of("profile_velocity"), "0 to 4294967295");
  EXPECT_EQ(text_of("ds402_statusword"), "0 to 65535") << "what it shows: nothing is written";
}

// The list is wrong if it contains a value that the drive refuses or lacks one that it accepts.
TEST(ValuesOfAnObject, AreThoseThatTheDriveTakes) {
  for (const ObjectDescription& object : kObjectTable) {
    const ObjectRow row = *find_object(object.address);
    const std::vector<std::int64_t> values = few_values(row);
    if (values.empty()) continue;
    for (std::int64_t value = -130; value <= 130; ++value) {
      const bool is_listed = std::ranges::binary_search(values, value);
      EXPECT_EQ(check_object_value(row, value) == AbortCode::none, is_listed)
          << object.variable_name << " = " << value;
    }
  }
}

TEST(AdviceOnARefusal, NamesTheSubIndicesAndTheValues) {
  EXPECT_EQ(advice_on({0x607D, 0}, AbortCode::subindex_does_not_exist),
            "607Dh has sub-indices 1 and 2");
  EXPECT_EQ(advice_on({0x5E10, 9}, AbortCode::subindex_does_not_exist),
            "5E10h has sub-indices 1, 2, 3, 4 and 5");
  EXPECT_EQ(advice_on({0x6081, 1}, AbortCode::subindex_does_not_exist),
            "6081h has only sub-index 0");
  EXPECT_EQ(advice_on({0x60F2, 0}, AbortCode::value_range_exceeded),
            "positioning_option_code accepts 0, 1 or 2");
  EXPECT_EQ(advice_on({0x605D, 0}, AbortCode::value_too_high), "halt_option_code accepts 1 to 4");
  EXPECT_EQ(advice_on({0x6041, 0}, AbortCode::write_of_read_only_object), "");
  EXPECT_EQ(advice_on({0x9999, 0}, AbortCode::object_does_not_exist), "");
}

TEST(NamesOfObjects, AreThoseThatAreRead) {
  const std::vector<std::string> names = names_of_objects();
  EXPECT_EQ(names.size(), kObjectTable.size() + kStandardNames.size());
  for (const std::string& name : names) EXPECT_TRUE(parse_object(name)) << name;
}

TEST(ObjectAddressText, IsReadInEveryFormThatIsWritten) {
  for (const ObjectDescription& object : kObjectTable) {
    const std::string standard =
        index_text(object.address.index) + ":" + std::to_string(object.address.subindex);
    for (const std::string& text : {address_text(object.address), standard}) {
      const auto spelled = parse_address(text);
      ASSERT_TRUE(spelled) << text;
      EXPECT_EQ(spelled->address(), object.address) << text;
      EXPECT_EQ(parse_object(text), object.address) << text;
    }
    EXPECT_EQ(parse_object(object.variable_name), object.address) << object.variable_name;
  }
}

TEST(ObjectAddressText, HasAnIndexAndPerhapsASubindexDecimalOrHexadecimal) {
  EXPECT_EQ(parse_address("0x6041")->subindex, std::nullopt);
  EXPECT_EQ(parse_address("0x6041:0")->subindex, 0);
  for (const char* const text :
       {"0x607D:10", "0X607d:010", "0x0607D:0x0A", "607Dh:0XA", "607dH:10"}) {
    const auto spelled = parse_address(text);
    ASSERT_TRUE(spelled) << text;
    EXPECT_EQ(spelled->address(), (ObjectAddress{0x607D, 10})) << text;
  }
  EXPECT_EQ(parse_address("FFFFh:255")->address(), (ObjectAddress{0xFFFF, 255}));
}

TEST(ObjectAddressText, IsNothingElse) {
  for (const char* const text : {"",          "6041",       "0x",           "h",
                                 "0xZZ",      "0x10000",    "x6041",        "-0x6041",
                                 "0x-1",      "0x+1",       "604h",         "06041h",
                                 "0x6041h",   " 0x6041",    "0x6041 ",      "0x607D:",
                                 ":1",        "0x607D:256", "0x607D:0x100", "0x607D:x",
                                 "0x607D:-1", "0x607D:1:2", "0x607D:0A",    "statusword"}) {
    EXPECT_FALSE(parse_address(text)) << text;
  }
}

TEST(ObjectAddressText, IsAcceptedWhereverANameIs) {
  EXPECT_EQ(parse_object("ds402_statusword"), (ObjectAddress{0x6041, 0}));
  EXPECT_EQ(parse_object("statusword"), (ObjectAddress{0x6041, 0})) << "the standard's name";
  EXPECT_EQ(parse_object("0x9999:7"), (ObjectAddress{0x9999, 7})) << "the drive refuses it";
  EXPECT_EQ(parse_object("no_such_object"), std::nullopt);
  EXPECT_EQ(parse_object("Statusword"), std::nullopt);
}

TEST(StandardNames, FindTheirObjectsAndDifferFromTheNamesOfTheManual) {
  for (const StandardName& standard : kStandardNames) {
    const auto row = find_object(standard.variable_name);
    ASSERT_TRUE(row) << standard.name;
    EXPECT_EQ(find_named(standard.name), row) << standard.name;
    EXPECT_FALSE(find_object(standard.name)) << standard.name;
  }
  EXPECT_EQ(find_named("ds402_statusword"), find_object(ObjectAddress{0x6041, 0}));
  EXPECT_EQ(find_named("speed_during_search_for_zero"), find_object(ObjectAddress{0x6099, 2}));
  EXPECT_FALSE(find_named("gravity"));
}

}  // namespace
}  // namespace vdrive
