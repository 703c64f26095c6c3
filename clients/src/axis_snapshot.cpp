// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/axis_snapshot.hpp"

#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <array>
#include <cstdio>

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
    FlagRow{Statusword::kSetPointAcknowledge, "set-point acknowledge"},
    FlagRow{Statusword::kFollowingError, "following error"},
};

}  // namespace

std::optional<std::int64_t> value_of(const AxisSnapshot& snapshot, ObjectAddress object) {
  const auto row = find_object(object);
  return row ? value_of(snapshot.status, *row) : std::nullopt;
}

std::vector<std::string_view> statusword_flags(std::uint16_t statusword) {
  std::vector<std::string_view> names;
  for (const FlagRow& row : kFlags) {
    if ((statusword & row.bit) != 0) names.push_back(row.name);
  }
  return names;
}

std::string describe_statusword(std::uint16_t statusword) {
  std::array<char, 16> hex{};
  std::snprintf(hex.data(), hex.size(), "0x%03X", unsigned{statusword});
  std::string text =
      std::string(hex.data()) + " " + std::string(to_string(decode_power_state(statusword)));
  std::string_view separator = ": ";
  for (const std::string_view name : statusword_flags(statusword)) {
    text.append(separator).append(name);
    separator = ", ";
  }
  return text;
}

std::string_view describe_mode(std::int8_t mode) noexcept {
  switch (mode) {
    case 0:
      return "none";
    case 1:
      return "profile position";
    case 3:
      return "profile velocity";
    case 4:
      return "profile torque";
    case 6:
      return "homing";
    default:
      return "unknown";
  }
}

}  // namespace vdrive::client
