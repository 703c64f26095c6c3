// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/axis_snapshot.hpp"

#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>

namespace vdrive::client {
namespace {

struct FlagRow {
  std::uint16_t bit;
  std::string_view name;
};

constexpr std::array kFlags{
    FlagRow{Statusword::kVoltageEnabled, "voltage enabled"},
    FlagRow{Statusword::kWarning, "warning"},
    FlagRow{Statusword::kRemote, "remote"},
    FlagRow{Statusword::kTargetReached, "target reached"},
    FlagRow{Statusword::kInternalLimitActive, "internal limit active"},
};

/// Bits 12 and 13, which each mode reads in its own way; empty: the mode does not use the bit.
struct ModeFlags {
  OperatingMode mode;
  std::string_view bit_12;
  std::string_view bit_13;
};

constexpr std::array kModeFlags{
    ModeFlags{OperatingMode::profile_position, "set-point acknowledge", "following error"},
    ModeFlags{OperatingMode::profile_velocity, "speed zero", "following error"},
    ModeFlags{OperatingMode::homing, "homing attained", "homing error"},
    ModeFlags{OperatingMode::cyclic_synchronous_position, "follows command", "following error"},
};
constexpr ModeFlags kOtherMode{OperatingMode::none, "bit 12", "following error"};

const ModeFlags& flags_of(OperatingMode mode) {
  const auto* const found = std::ranges::find_if(kModeFlags, [mode](const ModeFlags& row) {
    return row.mode == mode;
  });
  return found == kModeFlags.end() ? kOtherMode : *found;
}

}  // namespace

std::optional<std::int64_t> value_of(const AxisSnapshot& snapshot, ObjectAddress object) {
  const auto row = find_object(object);
  return row ? value_of(snapshot.status, *row) : std::nullopt;
}

std::vector<std::string_view> statusword_flags(std::uint16_t statusword, OperatingMode mode) {
  std::vector<std::string_view> names;
  for (const FlagRow& row : kFlags) {
    if ((statusword & row.bit) != 0) names.push_back(row.name);
  }
  const ModeFlags& flags = flags_of(mode);
  if ((statusword & 1U << 12U) != 0) names.push_back(flags.bit_12);
  if ((statusword & 1U << 13U) != 0) {
    // Outside Operation enabled the bit is the fault's, whatever the mode makes of it.
    const bool enabled = decode_power_state(statusword) == PowerState::operation_enabled;
    names.push_back(enabled ? flags.bit_13 : kOtherMode.bit_13);
  }
  return names;
}

std::string describe_statusword(std::uint16_t statusword, OperatingMode mode) {
  std::string text =
      hex(statusword, 3) + " " + std::string(to_string(decode_power_state(statusword)));
  std::string_view separator = ": ";
  for (const std::string_view name : statusword_flags(statusword, mode)) {
    text.append(separator).append(name);
    separator = ", ";
  }
  return text;
}

}  // namespace vdrive::client
