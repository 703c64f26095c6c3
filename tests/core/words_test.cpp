// SPDX-License-Identifier: Apache-2.0
// Controlword decoding, statusword bits and error codes against the tables of the manual and of
// CiA 402.
#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/abort_code.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive {
namespace {

struct StatePattern {
  PowerState state;
  std::uint16_t mask;
  std::uint16_t value;
};

// Manual, "bit0-bit3, bit5, bit6": x0xx 0000 and so on; x = don't care.
constexpr std::array<StatePattern, 8> kPatterns{{
    {PowerState::not_ready_to_switch_on, 0b0100'1111, 0b0000'0000},
    {PowerState::switch_on_disabled, 0b0100'1111, 0b0100'0000},
    {PowerState::ready_to_switch_on, 0b0110'1111, 0b0010'0001},
    {PowerState::switched_on, 0b0110'1111, 0b0010'0011},
    {PowerState::operation_enabled, 0b0110'1111, 0b0010'0111},
    {PowerState::quick_stop_active, 0b0110'1111, 0b0000'0111},
    {PowerState::fault_reaction_active, 0b0100'1111, 0b0000'1111},
    {PowerState::fault, 0b0100'1111, 0b0000'1000},
}};

TEST(Statusword, DecodesEveryValueByTheMasksOfTheManual) {
  for (std::uint32_t word = 0; word <= 0xFFFF; ++word) {
    PowerState expected = PowerState::not_ready_to_switch_on;
    for (const StatePattern& pattern : kPatterns) {
      if ((word & pattern.mask) == pattern.value) expected = pattern.state;
    }
    ASSERT_EQ(decode_power_state(static_cast<std::uint16_t>(word)), expected) << std::hex << word;
  }
}

TEST(Statusword, EncodesEachStateAndSetsBit5OnlyWhereTheDriveMayRun) {
  for (const StatePattern& pattern : kPatterns) {
    const std::uint16_t word = statusword_of(pattern.state);

    EXPECT_EQ(word & pattern.mask, pattern.value) << to_string(pattern.state);
    EXPECT_EQ(word & ~0x6FU, 0U) << "only bits 0 to 3, 5 and 6: " << to_string(pattern.state);
    const bool released = pattern.state == PowerState::ready_to_switch_on ||
                          pattern.state == PowerState::switched_on ||
                          pattern.state == PowerState::operation_enabled;
    EXPECT_EQ((word & Statusword::kQuickStop) != 0, released) << to_string(pattern.state);
  }
}

TEST(Statusword, HasTheManualsBitNumbers) {
  EXPECT_EQ(Statusword::kReadyToSwitchOn, 0x0001);
  EXPECT_EQ(Statusword::kSwitchedOn, 0x0002);
  EXPECT_EQ(Statusword::kOperationEnabled, 0x0004);
  EXPECT_EQ(Statusword::kFault, 0x0008);
  EXPECT_EQ(Statusword::kVoltageEnabled, 0x0010);
  EXPECT_EQ(Statusword::kQuickStop, 0x0020);
  EXPECT_EQ(Statusword::kSwitchOnDisabled, 0x0040);
  EXPECT_EQ(Statusword::kWarning, 0x0080);
  EXPECT_EQ(Statusword::kRemote, 0x0200);
  EXPECT_EQ(Statusword::kTargetReached, 0x0400);
  EXPECT_EQ(Statusword::kInternalLimitActive, 0x0800);
  EXPECT_EQ(Statusword::kSetPointAcknowledge, 0x1000);
  EXPECT_EQ(Statusword::kFollowingError, 0x2000);
}

TEST(PowerState, IsNamedAsTheManualNamesIt) {
  const std::array<std::string_view, 8> names{
      "Not ready to switch on", "Switch on disabled", "Ready to switch on",    "Switched on",
      "Operation enabled",      "Quick stop active",  "Fault reaction active", "Fault"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(to_string(static_cast<PowerState>(i)), names[i]);
  }
}

TEST(Controlword, HasTheManualsBitNumbers) {
  EXPECT_EQ(Controlword::kSwitchOn, 0x0001);
  EXPECT_EQ(Controlword::kEnableVoltage, 0x0002);
  EXPECT_EQ(Controlword::kQuickStop, 0x0004);
  EXPECT_EQ(Controlword::kEnableOperation, 0x0008);
  EXPECT_EQ(Controlword::kNewSetPoint, 0x0010);
  EXPECT_EQ(Controlword::kChangeSetImmediately, 0x0020);
  EXPECT_EQ(Controlword::kRelative, 0x0040);
  EXPECT_EQ(Controlword::kFaultReset, 0x0080);
  EXPECT_EQ(Controlword::kHalt, 0x0100);
}

struct CommandPattern {
  PowerCommand command;
  std::uint16_t mask;
  std::uint16_t value;
};

// CiA 402, command coding: bit 7 = 0 in each of them.
constexpr std::array<CommandPattern, 5> kCommands{{
    {PowerCommand::shutdown, 0x87, 0x06},
    {PowerCommand::switch_on, 0x8F, 0x07},
    {PowerCommand::enable_operation, 0x8F, 0x0F},
    {PowerCommand::disable_voltage, 0x82, 0x00},
    {PowerCommand::quick_stop, 0x86, 0x02},
}};

TEST(Controlword, WithBit7LowGivesTheCommandOfTheTable) {
  for (std::uint32_t word = 0; word <= 0xFFFF; ++word) {
    if ((word & 0x80U) != 0) continue;
    int matches = 0;
    for (const CommandPattern& pattern : kCommands) {
      if ((word & pattern.mask) == pattern.value) {
        ++matches;
        for (const unsigned previous : {0x0000U, 0x0080U, 0xFFFFU}) {
          ASSERT_EQ(decode_command(static_cast<std::uint16_t>(word),
                                   static_cast<std::uint16_t>(previous)),
                    pattern.command)
              << std::hex << word << " after " << previous;
        }
      }
    }
    ASSERT_EQ(matches, 1) << std::hex << word;
  }
}

TEST(Controlword, WithBit7HighGivesOnlyAResetOnItsRisingEdge) {
  for (std::uint32_t i = 0; i <= 0xFFFF; ++i) {
    const auto word = static_cast<std::uint16_t>(i | 0x80U);
    ASSERT_EQ(decode_command(word, static_cast<std::uint16_t>(i & ~0x80U)),
              PowerCommand::fault_reset);
    ASSERT_EQ(decode_command(word, static_cast<std::uint16_t>(i | 0x80U)), PowerCommand::none);
  }
}

TEST(ErrorCode, SetsTheBitsOfItsGroupInTheErrorRegister) {
  // CiA 301, 1001h: bit 0 generic, 1 current, 2 voltage, 3 temperature, 4 communication,
  // 5 device profile.
  const std::array<std::pair<ErrorCode, std::uint8_t>, 9> expected{{
      {ErrorCode::continuous_over_current, 0b00'0011},
      {ErrorCode::load_level, 0b00'0011},
      {ErrorCode::dc_link_under_voltage, 0b00'0101},
      {ErrorCode::excess_temperature_drive, 0b00'1001},
      {ErrorCode::parameter_memory, 0b00'0001},
      {ErrorCode::life_guard_or_heartbeat, 0b01'0001},
      {ErrorCode::incremental_sensor_1_fault, 0b10'0001},
      {ErrorCode::following_error, 0b10'0001},
      {ErrorCode::sync_controller, 0b10'0001},
  }};
  for (const auto& [code, bits] : expected) {
    EXPECT_EQ(error_register_of(code), bits) << describe(code);
    EXPECT_NE(describe(code), "unknown error");
  }
  EXPECT_EQ(error_register_of(ErrorCode::none), 0);
  EXPECT_EQ(describe(ErrorCode::none), "no error");
  EXPECT_EQ(describe(ErrorCode{0x1234}), "unknown error");
  EXPECT_EQ(error_register_of(ErrorCode{0x1234}), 0);
}

TEST(ErrorCode, HasTheNumbersOfCiA402) {
  EXPECT_EQ(static_cast<int>(ErrorCode::continuous_over_current), 0x2310);
  EXPECT_EQ(static_cast<int>(ErrorCode::load_level), 0x2350);
  EXPECT_EQ(static_cast<int>(ErrorCode::dc_link_under_voltage), 0x3220);
  EXPECT_EQ(static_cast<int>(ErrorCode::excess_temperature_drive), 0x4310);
  EXPECT_EQ(static_cast<int>(ErrorCode::parameter_memory), 0x5530);
  EXPECT_EQ(static_cast<int>(ErrorCode::incremental_sensor_1_fault), 0x7305);
  EXPECT_EQ(static_cast<int>(ErrorCode::life_guard_or_heartbeat), 0x8130);
  EXPECT_EQ(static_cast<int>(ErrorCode::following_error), 0x8611);
  EXPECT_EQ(static_cast<int>(ErrorCode::sync_controller), 0x8700);
}

TEST(ErrorCode, ForcesCoastingWhereTheDriveCannotBrake) {
  EXPECT_TRUE(forces_coasting(ErrorCode::dc_link_under_voltage));
  EXPECT_TRUE(forces_coasting(ErrorCode::incremental_sensor_1_fault));
  EXPECT_FALSE(forces_coasting(ErrorCode::continuous_over_current));
  EXPECT_FALSE(forces_coasting(ErrorCode::load_level));
  EXPECT_FALSE(forces_coasting(ErrorCode::excess_temperature_drive));
  EXPECT_FALSE(forces_coasting(ErrorCode::life_guard_or_heartbeat));
  EXPECT_FALSE(forces_coasting(ErrorCode::following_error));
  EXPECT_FALSE(forces_coasting(ErrorCode::sync_controller));
  EXPECT_FALSE(forces_coasting(ErrorCode::none));
  EXPECT_FALSE(forces_coasting(ErrorCode{0x1234}));
}

TEST(AbortCode, EveryCodeOfCiA301HasItsOwnText) {
  const std::array<std::uint32_t, 26> codes{
      0x05030000, 0x05040000, 0x05040001, 0x05040005, 0x06010000, 0x06010001, 0x06010002,
      0x06020000, 0x06040041, 0x06040042, 0x06040043, 0x06040047, 0x06060000, 0x06070010,
      0x06070012, 0x06070013, 0x06090011, 0x06090030, 0x06090031, 0x06090032, 0x06090036,
      0x08000000, 0x08000020, 0x08000021, 0x08000022, 0x08000024};
  std::vector<std::string_view> texts;
  for (const std::uint32_t code : codes) {
    const std::string_view text = describe(AbortCode{code});
    EXPECT_NE(text, "unknown abort code") << std::hex << code;
    EXPECT_THAT(texts, testing::Not(testing::Contains(text)));
    texts.push_back(text);
  }
  EXPECT_EQ(describe(AbortCode{1}), "unknown abort code");
}

// CiA 402-2: bits 4 to 6 of the controlword and bits 12 and 13 of the statusword are mode-specific.
TEST(BitNames, AreThoseOfTheMode) {
  EXPECT_EQ(controlword_bit_name(0x0010, OperatingMode::profile_position), "new set-point");
  EXPECT_EQ(controlword_bit_name(0x0010, OperatingMode::homing), "start homing");
  EXPECT_EQ(controlword_bit_name(0x0010, OperatingMode::profile_velocity), "");
  EXPECT_EQ(statusword_bit_name(0x1000, OperatingMode::profile_position), "set-point acknowledge");
  EXPECT_EQ(statusword_bit_name(0x1000, OperatingMode::profile_velocity), "speed zero");
  EXPECT_EQ(statusword_bit_name(0x2000, OperatingMode::homing), "homing error");
  EXPECT_EQ(statusword_bit_name(0x2000, OperatingMode::profile_position), "following error");
  EXPECT_EQ(controlword_bit_name(0x0010, OperatingMode::interpolated_position),
            "enable interpolation");
  EXPECT_EQ(statusword_bit_name(0x1000, OperatingMode::interpolated_position),
            "interpolation active");
  EXPECT_EQ(statusword_bit_name(0x1000, OperatingMode::cyclic_synchronous_velocity),
            "follows command");
  EXPECT_EQ(statusword_bit_name(0x1000, OperatingMode::cyclic_synchronous_torque),
            "follows command");
}

TEST(BitNames, AreTheSameInEveryModeForTheBitsOfTheState) {
  for (const OperatingMode mode : {OperatingMode::none, OperatingMode::homing}) {
    EXPECT_EQ(controlword_bit_name(0x0080, mode), "fault reset");
    EXPECT_EQ(statusword_bit_name(0x0008, mode), "fault");
    EXPECT_EQ(statusword_bit_name(0x0020, mode), "quick stop");
  }
}

// CiA 402-2: negative numbers are manufacturer-specific; the drive has no such mode.
TEST(OperatingModes, HaveANameAndTheBitsOfAllModesWhereTheyHaveNoRow) {
  constexpr auto kForeign = static_cast<OperatingMode>(-1);
  EXPECT_EQ(to_string(kForeign), "unknown");
  EXPECT_EQ(statusword_bit_name(0x1000, kForeign), "bit 12");
  EXPECT_EQ(controlword_bit_name(0x0010, kForeign), "");
  EXPECT_EQ(controlword_bit_name(0x0100, kForeign), "halt");
  EXPECT_FALSE(is_operating_mode(-1));
}

TEST(BitNames, AreEmptyForUnusedBits) {
  for (const std::uint16_t bit : std::array<std::uint16_t, 3>{0x0100, 0x4000, 0x8000}) {
    EXPECT_EQ(statusword_bit_name(bit, OperatingMode::profile_position), "") << bit;
  }
  EXPECT_EQ(controlword_bit_name(0x8000, OperatingMode::profile_position), "");
}

/// @return the name of the enumerator, as the compiler writes it.
template <AbortCode kCode>
std::string_view enumerator_of_code() {
  std::string_view text = __PRETTY_FUNCTION__;
  text.remove_prefix(text.rfind("AbortCode::") + std::string_view("AbortCode::").size());
  return text.substr(0, text.find_first_of(";]"));
}

template <std::size_t... kPlaces>
auto enumerators_of_codes(std::index_sequence<kPlaces...> /*places*/) {
  return std::array{enumerator_of_code<kAbortCodes[kPlaces].code>()...};
}

TEST(AbortCodes, AreNamedAsTheirEnumeratorsInTheOrderOfTheirNumbers) {
  const auto names = enumerators_of_codes(std::make_index_sequence<kAbortCodes.size()>());
  for (std::size_t place = 0; place < names.size(); ++place) {
    EXPECT_EQ(names[place], kAbortCodes[place].name);
    EXPECT_EQ(describe(kAbortCodes[place].code), kAbortCodes[place].words);
  }
  EXPECT_TRUE(std::ranges::is_sorted(kAbortCodes, {}, &AbortCodeRow::code));
}

TEST(AbortCodes, EachHaveARow) {
  std::ifstream header(VDRIVE_SOURCE_DIR "/core/include/vdrive/dictionary/abort_code.hpp");
  std::size_t enumerators = 0;
  for (std::string line; std::getline(header, line);) {
    enumerators += line.find(" = 0") != std::string::npos ? 1U : 0U;
  }
  EXPECT_EQ(enumerators, kAbortCodes.size());
}

TEST(ErrorCodes, AreListedByNumberAndEachHasWords) {
  EXPECT_FALSE(error_codes().empty());
  ErrorCode last = ErrorCode::none;
  for (const ErrorCode code : error_codes()) {
    EXPECT_LT(last, code);
    EXPECT_NE(describe(code), "unknown error");
    last = code;
  }
}

}  // namespace
}  // namespace vdrive
