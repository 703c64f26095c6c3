// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/error_code.hpp"

#include <algorithm>
#include <array>

namespace vdrive {
namespace {

struct ErrorRow {
  ErrorCode code;
  std::string_view text;
  std::uint8_t register_bits;  // 1001h beside the generic bit
  bool coasts;
};

// 1001h: 1 current, 2 voltage, 3 temperature, 4 communication, 5 device profile.
constexpr std::array<ErrorRow, 9> kErrors{{
    {ErrorCode::continuous_over_current, "continuous over-current", 1U << 1U, false},
    {ErrorCode::load_level, "load level fault", 1U << 1U, false},
    {ErrorCode::dc_link_under_voltage, "DC link under-voltage", 1U << 2U, true},
    {ErrorCode::excess_temperature_drive, "excess temperature drive", 1U << 3U, false},
    {ErrorCode::parameter_memory, "parameter memory error", 0, false},
    {ErrorCode::incremental_sensor_1_fault, "incremental sensor 1 fault", 1U << 5U, true},
    {ErrorCode::life_guard_or_heartbeat, "life guard or heartbeat error", 1U << 4U, false},
    {ErrorCode::following_error, "following error", 1U << 5U, false},
    {ErrorCode::sync_controller, "sync controller error", 1U << 5U, false},
}};

constexpr auto kCodes = [] {
  std::array<ErrorCode, kErrors.size()> codes{};
  std::ranges::transform(kErrors, codes.begin(), &ErrorRow::code);
  return codes;
}();

constexpr std::uint8_t kGenericError = 1U << 0U;

const ErrorRow* find(ErrorCode code) noexcept {
  for (const ErrorRow& row : kErrors) {
    if (row.code == code) return &row;
  }
  return nullptr;
}

}  // namespace

std::span<const ErrorCode> error_codes() noexcept {
  return kCodes;
}

std::string_view describe(ErrorCode code) noexcept {
  if (code == ErrorCode::none) return "no error";
  const ErrorRow* const row = find(code);
  return row == nullptr ? "unknown error" : row->text;
}

std::uint8_t error_register_of(ErrorCode code) noexcept {
  const ErrorRow* const row = find(code);
  return row == nullptr ? 0 : static_cast<std::uint8_t>(row->register_bits | kGenericError);
}

bool forces_coasting(ErrorCode code) noexcept {
  const ErrorRow* const row = find(code);
  return row != nullptr && row->coasts;
}

}  // namespace vdrive
