// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/axis_snapshot.hpp"

#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

namespace vdrive::client {

std::optional<std::int64_t> value_of(const AxisSnapshot& snapshot, ObjectAddress object) {
  const auto row = find_object(object);
  return row ? value_of(snapshot.status, *row) : std::nullopt;
}

std::optional<std::int64_t> seconds_to(const AxisSnapshot& axis, std::int32_t target) noexcept {
  const std::int64_t speed = axis.status.velocity_demand_value;
  const std::int64_t way = std::int64_t{target} - axis.status.position_demand_value;
  const bool leads_there = (way > 0 && speed > 0) || (way < 0 && speed < 0);
  return leads_there ? std::optional(1 + way / speed) : std::nullopt;
}

std::vector<std::string_view> statusword_flags(std::uint16_t statusword, OperatingMode mode) {
  // Outside Operation enabled, bit 13 means following error, whatever the mode uses it for.
  const bool enabled = decode_power_state(statusword) == PowerState::operation_enabled;
  std::vector<std::string_view> names;
  for (unsigned flags = statusword & ~unsigned{Statusword::kState}; flags != 0;
       flags &= flags - 1U) {
    const auto bit = static_cast<std::uint16_t>(flags & (~flags + 1U));
    const bool is_of_fault = bit == Statusword::kFollowingError && !enabled;
    const auto name = statusword_bit_name(bit, is_of_fault ? OperatingMode::none : mode);
    if (!name.empty()) names.push_back(name);
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

std::string what_it_shows(const AxisSnapshot& axis) {
  std::string text = "shows ";
  if (axis.status.error_code != 0) {
    text += "error " + hex(axis.status.error_code, 4) + " " +
            std::string(describe(static_cast<ErrorCode>(axis.status.error_code))) + ", ";
  }
  text += describe_statusword(axis.status.ds402_statusword, axis.mode());
  if (static_cast<ErrorCode>(axis.status.error_code) == ErrorCode::life_guard_or_heartbeat) {
    text +=
        "; the bench received nothing from the owner of the axis in time: increase "
        "watchdog.timeout_ms of the bench, or use lock-step and join its clock";
  }
  return text;
}

}  // namespace vdrive::client
