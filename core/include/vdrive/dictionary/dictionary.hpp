// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {

/// The object dictionary, sorted by index and sub-index. For constant expressions use
/// vdrive/dictionary/object_table.hpp.
extern const std::span<const ObjectDescription> kObjectTable;

/// The rows that 1010h stores, in dictionary order.
extern const std::span<const ObjectRow> kStoredRows;

/// The values to write to 1010h:01 and 1011h:01; any other value is refused with
/// AbortCode::cannot_store_or_transfer.
inline constexpr std::int64_t kStoreSignature = 0x65766173;    ///< "save", low byte first
inline constexpr std::int64_t kRestoreSignature = 0x64616F6C;  ///< "load"

/// @return the row at `address`, or nothing when there is no such object.
[[nodiscard]] std::optional<ObjectRow> find_object(ObjectAddress address) noexcept;

/// @return the row with this `variable_name`, or nothing.
[[nodiscard]] std::optional<ObjectRow> find_object(std::string_view variable_name) noexcept;

/// @return the description of `row`; `row` < kObjectTable.size().
[[nodiscard]] const ObjectDescription& describe(ObjectRow row) noexcept;

[[nodiscard]] bool has_role(ObjectRow row, Role role) noexcept;

/// @return whether there is an object at `address` with this role.
[[nodiscard]] bool has_role(ObjectAddress address, Role role) noexcept;

/// @return the units in English, such as "VelUU" or "TqCU (mA)". The manual gives the short name
///         first, then an explanation in Chinese in brackets.
[[nodiscard]] std::string english_units(const ObjectDescription& object);

/// @return an address such as "0x6081", or "0x607D:1" for a sub-index other than 0.
[[nodiscard]] std::string address_text(ObjectAddress address);

/// @return AbortCode::object_does_not_exist when no object has this index,
///         AbortCode::subindex_does_not_exist when the index has no such sub-index, else none.
[[nodiscard]] AbortCode check_address(ObjectAddress address) noexcept;

/// @return AbortCode::write_of_read_only_object for a read-only row, AbortCode::value_too_high or
///         value_too_low outside the range of the row or of its data type, otherwise none. Rules
///         that depend on the state of the drive are not checked here.
[[nodiscard]] AbortCode check_write(ObjectRow row, std::int64_t value) noexcept;

/// Checks a value against the rules of `check_write` and the narrower ones that follow from its
/// meaning, such as the modes of 6060h and the methods of 6098h.
/// @return AbortCode::value_range_exceeded or AbortCode::cannot_store_or_transfer for a value
///         without a meaning, otherwise the result of `check_write`.
[[nodiscard]] AbortCode check_object_value(ObjectRow row, std::int64_t value) noexcept;

/// The same for a modulo axis (607Bh), which also accepts bits 6 and 7 of 60F2h: the direction of
/// travel to a target.
[[nodiscard]] AbortCode check_value_on_modulo_axis(ObjectRow row, std::int64_t value) noexcept;

/// @return the values that a writable object accepts, in ascending order, if there are at most 40;
///         otherwise empty.
[[nodiscard]] std::vector<std::int64_t> few_values(ObjectRow row);

/// @return the values that an object accepts, such as "0 to 8" or "0, 1 or 2"; more than 16 values
///         as ranges: "-4 to 14, 17 to 30, 33 to 35 or 37".
[[nodiscard]] std::string values_text(ObjectRow row);

}  // namespace vdrive
