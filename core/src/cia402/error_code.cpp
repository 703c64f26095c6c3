// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/error_code.hpp"

#include <algorithm>
#include <array>

namespace vdrive {
namespace {

struct ErrorRow {
  ErrorCode code;
  std::string_view text;
  std::uint8_t register_bits;  // 1001h without the generic bit
  bool coasts;
  std::string_view remedy;
};

// 1001h: 1 current, 2 voltage, 3 temperature, 4 communication, 5 device profile.
constexpr std::array<ErrorRow, 9> kErrors{{
    {ErrorCode::continuous_over_current, "continuous over-current", 1U << 1U, false,
     "Lower the acceleration or the load, or check what blocks the axis; the rated current is "
     "6075h."},
    {ErrorCode::load_level, "load level fault", 1U << 1U, false,
     "Let the motor cool; move with lower accelerations or longer pauses."},
    {ErrorCode::dc_link_under_voltage, "DC link under-voltage", 1U << 2U, true,
     "Check the supply and its fuses; the drive coasts until the voltage is back."},
    {ErrorCode::excess_temperature_drive, "excess temperature drive", 1U << 3U, false,
     "Let the drive cool, and check its ventilation."},
    {ErrorCode::parameter_memory, "parameter memory error", 0, false,
     "Restore the defaults (1011h) and store the parameters again (1010h)."},
    {ErrorCode::incremental_sensor_1_fault, "incremental sensor 1 fault", 1U << 5U, true,
     "Check the encoder and its cable; then home the axis again."},
    {ErrorCode::life_guard_or_heartbeat, "life guard or heartbeat error", 1U << 4U, false,
     "Find out why the master stopped sending; a longer watchdog time or another 6007h only hides "
     "the problem."},
    {ErrorCode::following_error, "following error", 1U << 5U, false,
     "Check what blocks the load; otherwise lower the acceleration or the speed, or widen 6065h "
     "and 6066h if that is acceptable."},
    {ErrorCode::sync_controller, "sync controller error", 1U << 5U, false,
     "Send a set-point every 60C2h, and SYNC on time."},
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

std::string_view remedy_of(ErrorCode code) noexcept {
  const ErrorRow* const row = find(code);
  return row == nullptr ? "" : row->remedy;
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
