// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace vdrive {

/// Result of an access to the object dictionary: the SDO abort codes of CiA 301, table "SDO abort
/// codes". The enumerator's value is the wire value; `none` means that the access was carried out.
enum class AbortCode : std::uint32_t {
  none = 0,
  toggle_bit_not_alternated = 0x05030000,
  protocol_timed_out = 0x05040000,
  unknown_command_specifier = 0x05040001,
  out_of_memory = 0x05040005,
  unsupported_access = 0x06010000,
  read_of_write_only_object = 0x06010001,
  write_of_read_only_object = 0x06010002,
  object_does_not_exist = 0x06020000,
  cannot_be_mapped_to_pdo = 0x06040041,
  pdo_length_exceeded = 0x06040042,
  parameter_incompatibility = 0x06040043,
  device_internal_incompatibility = 0x06040047,
  hardware_error = 0x06060000,
  data_length_does_not_match = 0x06070010,
  length_too_high = 0x06070012,
  length_too_low = 0x06070013,
  subindex_does_not_exist = 0x06090011,
  value_range_exceeded = 0x06090030,
  value_too_high = 0x06090031,
  value_too_low = 0x06090032,
  maximum_below_minimum = 0x06090036,
  general_error = 0x08000000,
  cannot_store_or_transfer = 0x08000020,
  refused_local_control = 0x08000021,
  refused_in_present_device_state = 0x08000022,
  no_data_available = 0x08000024,
};

struct AbortCodeRow {
  AbortCode code{};
  std::string_view name;   ///< as an identifier in programs
  std::string_view words;  ///< as in the standard
};

/// Every abort code, by number.
inline constexpr std::array kAbortCodes{
    AbortCodeRow{AbortCode::none, "none", "no error"},
    AbortCodeRow{AbortCode::toggle_bit_not_alternated, "toggle_bit_not_alternated",
                 "toggle bit not alternated"},
    AbortCodeRow{AbortCode::protocol_timed_out, "protocol_timed_out", "SDO protocol timed out"},
    AbortCodeRow{AbortCode::unknown_command_specifier, "unknown_command_specifier",
                 "command specifier not valid or unknown"},
    AbortCodeRow{AbortCode::out_of_memory, "out_of_memory", "out of memory"},
    AbortCodeRow{AbortCode::unsupported_access, "unsupported_access",
                 "unsupported access to an object"},
    AbortCodeRow{AbortCode::read_of_write_only_object, "read_of_write_only_object",
                 "attempt to read a write-only object"},
    AbortCodeRow{AbortCode::write_of_read_only_object, "write_of_read_only_object",
                 "attempt to write a read-only object"},
    AbortCodeRow{AbortCode::object_does_not_exist, "object_does_not_exist",
                 "object does not exist in the object dictionary"},
    AbortCodeRow{AbortCode::cannot_be_mapped_to_pdo, "cannot_be_mapped_to_pdo",
                 "object cannot be mapped to the PDO"},
    AbortCodeRow{AbortCode::pdo_length_exceeded, "pdo_length_exceeded",
                 "number and length of the objects would exceed the PDO length"},
    AbortCodeRow{AbortCode::parameter_incompatibility, "parameter_incompatibility",
                 "general parameter incompatibility"},
    AbortCodeRow{AbortCode::device_internal_incompatibility, "device_internal_incompatibility",
                 "general internal incompatibility in the device"},
    AbortCodeRow{AbortCode::hardware_error, "hardware_error",
                 "access failed due to a hardware error"},
    AbortCodeRow{AbortCode::data_length_does_not_match, "data_length_does_not_match",
                 "data type does not match, length does not match"},
    AbortCodeRow{AbortCode::length_too_high, "length_too_high",
                 "data type does not match, length too high"},
    AbortCodeRow{AbortCode::length_too_low, "length_too_low",
                 "data type does not match, length too low"},
    AbortCodeRow{AbortCode::subindex_does_not_exist, "subindex_does_not_exist",
                 "sub-index does not exist"},
    AbortCodeRow{AbortCode::value_range_exceeded, "value_range_exceeded",
                 "invalid value for the parameter"},
    AbortCodeRow{AbortCode::value_too_high, "value_too_high",
                 "value of the parameter written too high"},
    AbortCodeRow{AbortCode::value_too_low, "value_too_low",
                 "value of the parameter written too low"},
    AbortCodeRow{AbortCode::maximum_below_minimum, "maximum_below_minimum",
                 "maximum value is less than minimum value"},
    AbortCodeRow{AbortCode::general_error, "general_error", "general error"},
    AbortCodeRow{AbortCode::cannot_store_or_transfer, "cannot_store_or_transfer",
                 "data cannot be transferred or stored to the application"},
    AbortCodeRow{AbortCode::refused_local_control, "refused_local_control",
                 "data cannot be transferred or stored because of local control"},
    AbortCodeRow{AbortCode::refused_in_present_device_state, "refused_in_present_device_state",
                 "data cannot be transferred or stored because of the present device state"},
    AbortCodeRow{AbortCode::no_data_available, "no_data_available", "no data available"},
};

/// @return the number that reports `code` in a reply or a frame.
[[nodiscard]] constexpr std::uint32_t wire_code(AbortCode code) noexcept {
  return static_cast<std::uint32_t>(code);
}

/// @return the standard's wording for `code`, or "unknown abort code".
[[nodiscard]] std::string_view describe(AbortCode code) noexcept;

}  // namespace vdrive
