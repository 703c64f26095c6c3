// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace vdrive {

/// Answer to an access of the object dictionary: the SDO abort codes of CiA 301, table "SDO abort
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

/// @return the number that a request or a frame is answered with.
[[nodiscard]] constexpr std::uint32_t wire_code(AbortCode code) noexcept {
  return static_cast<std::uint32_t>(code);
}

/// @return the standard's wording for `code`, or "unknown abort code".
[[nodiscard]] std::string_view describe(AbortCode code) noexcept;

}  // namespace vdrive
