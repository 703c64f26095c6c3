// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {

/// Position of a row in `kObjectTable`; rows are sorted by index, then sub-index.
using ObjectRow = std::uint16_t;

inline constexpr std::size_t kObjectCount = kObjectTable.size();

/// Of objects, names, types, access and ranges; clients find it in the description of a bench. The
/// second number grows with every change of a row, the first with one that existing clients cannot
/// use.
inline constexpr std::string_view kDictionaryVersion = "1.4";

/// What has to be written to 1010h:01 and 1011h:01; any other value is refused with
/// AbortCode::cannot_store_or_transfer.
inline constexpr std::int64_t kStoreSignature = 0x65766173;    ///< "save", least byte first
inline constexpr std::int64_t kRestoreSignature = 0x64616F6C;  ///< "load"

/// How many objects 1010h stores.
inline constexpr std::size_t kStoredCount = [] {
  std::size_t count = 0;
  for (const ObjectDescription& row : kObjectTable) {
    count += row.storage == Storage::flash ? 1U : 0U;
  }
  return count;
}();

/// The rows that 1010h stores, in their order.
inline constexpr std::array<ObjectRow, kStoredCount> kStoredRows = [] {
  std::array<ObjectRow, kStoredCount> rows{};
  std::size_t count = 0;
  for (std::size_t row = 0; row < kObjectCount; ++row) {
    if (kObjectTable[row].storage == Storage::flash) {
      rows[count] = static_cast<ObjectRow>(row);
      ++count;
    }
  }
  return rows;
}();

/// @return the row at `address`, or nothing when there is no such object.
[[nodiscard]] constexpr std::optional<ObjectRow> find_object(ObjectAddress address) noexcept {
  std::size_t first = 0;
  std::size_t last = kObjectCount;
  while (first < last) {
    const std::size_t middle = first + (last - first) / 2;
    if (kObjectTable[middle].address < address) {
      first = middle + 1;
    } else {
      last = middle;
    }
  }
  if (first < kObjectCount && kObjectTable[first].address == address) {
    return static_cast<ObjectRow>(first);
  }
  return std::nullopt;
}

/// @return the row with this `variable_name`, or nothing.
[[nodiscard]] constexpr std::optional<ObjectRow> find_object(
    std::string_view variable_name) noexcept {
  for (std::size_t row = 0; row < kObjectCount; ++row) {
    if (kObjectTable[row].variable_name == variable_name) return static_cast<ObjectRow>(row);
  }
  return std::nullopt;
}

/// @return the description of `row`; `row` < kObjectCount.
[[nodiscard]] constexpr const ObjectDescription& describe(ObjectRow row) noexcept {
  ensure(row < kObjectCount, "a row of the dictionary is inside its table");
  return kObjectTable[row];
}

[[nodiscard]] constexpr bool has_role(ObjectRow row, Role role) noexcept {
  return describe(row).role == role;
}

/// @return whether there is an object at `address` and it has this role.
[[nodiscard]] constexpr bool has_role(ObjectAddress address, Role role) noexcept {
  const auto row = find_object(address);
  return row && has_role(*row, role);
}

/// @return the units in English, such as "VelUU" or "TqCU (mA)": the manual writes their short name
///         first and explains it in Chinese, in brackets.
[[nodiscard]] std::string english_units(const ObjectDescription& object);

/// @return such as "0x6081", or "0x607D:1" for a sub-index other than 0.
[[nodiscard]] std::string address_text(ObjectAddress address);

/// @return AbortCode::object_does_not_exist when no object has this index,
///         AbortCode::subindex_does_not_exist when the index has no such sub-index, else none.
[[nodiscard]] AbortCode check_address(ObjectAddress address) noexcept;

/// @return AbortCode::write_of_read_only_object for a read-only row,
///         AbortCode::value_too_high / value_too_low outside the row's range (the object's type
///         included), else none. Rules that need the drive's state are the drive's own.
[[nodiscard]] AbortCode check_write(ObjectRow row, std::int64_t value) noexcept;

/// The rules of an object for its value: those of `check_write`, and the narrower ones of what the
/// value means, such as the modes of 6060h and the methods of 6098h.
/// @return AbortCode::value_range_exceeded or AbortCode::cannot_store_or_transfer for a value
///         without a meaning, else that of `check_write`.
[[nodiscard]] AbortCode check_object_value(ObjectRow row, std::int64_t value) noexcept;

/// The same on a modulo axis (607Bh), which takes bits 6 and 7 of 60F2h, too: the direction in
/// which it goes to a target.
[[nodiscard]] AbortCode check_value_on_modulo_axis(ObjectRow row, std::int64_t value) noexcept;

/// @return the values that a writable object takes, in ascending order, where they are at most 40;
///         empty where they are more.
[[nodiscard]] std::vector<std::int64_t> few_values(ObjectRow row);

/// @return the values that an object takes, such as "0 to 8", "0, 1 or 2", or more than 16
///         of them by their runs: "-4 to 14, 17 to 30, 33 to 35 or 37".
[[nodiscard]] std::string values_text(ObjectRow row);

namespace literals {

/// Row of an object by its variable_name; an unknown name does not compile:
/// `"profile_velocity"_object`.
consteval ObjectRow operator""_object(const char* variable_name, std::size_t length) {
  return *find_object(std::string_view{variable_name, length});
}

}  // namespace literals
}  // namespace vdrive
