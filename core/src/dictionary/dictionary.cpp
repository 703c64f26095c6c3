// SPDX-License-Identifier: Apache-2.0
#include "vdrive/dictionary/dictionary.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/cia402/homing_method.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/positioning_option.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace vdrive {
namespace {

constexpr bool sorted_without_duplicates() {
  for (std::size_t row = 1; row < kObjectCount; ++row) {
    if (!(kObjectRows[row - 1].address < kObjectRows[row].address)) return false;
  }
  return true;
}

static_assert(sorted_without_duplicates(), "find_row searches by bisection");

constexpr std::array<ObjectRow, kStoredCount> kStored = [] {
  std::array<ObjectRow, kStoredCount> rows{};
  std::size_t count = 0;
  for (std::size_t row = 0; row < kObjectCount; ++row) {
    if (kObjectRows[row].storage == Storage::flash) rows[count++] = static_cast<ObjectRow>(row);
  }
  return rows;
}();

using namespace vdrive::literals;

/// Manufacturer-specific bits 9, 14 and 15 of 6041h, on which drives differ.
constexpr std::int64_t kMakerBits = 0xC200;

/// Rows that answer every value without a meaning with 0x06090030, even where a value outside their
/// limits would otherwise give "too high" or "too low".
bool is_judged_by_meaning(ObjectRow row) {
  return row == "error_history_count"_object || row == "homing_method"_object ||
         row == "motion_profile_type"_object || row == "profile_jerk_use"_object;
}

bool is_within_type(ObjectRow row, std::int64_t value) {
  const TypeRange type = range_of(describe(row).data_type);
  return value >= type.lowest && value <= type.highest;
}

/// Bits 6, 7, 14 and 15 of 60B8h are manufacturer-specific and unused here; the source value 3, in
/// bits 2 and 3 or 10 and 11, is reserved.
bool is_touch_probe_function(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  return (bits & 0xC0C0U) == 0 && (bits & 0x000CU) != 0x000CU && (bits & 0x0C00U) != 0x0C00U;
}

/// The additional rules of individual objects, for a value within its type.
bool has_meaning(ObjectRow row, std::int64_t value) {
  switch (row) {
    case "op_mode_cmd"_object:
      return is_operating_mode(value);
    case "homing_method"_object:
      return is_homing_method(value);
    case "motion_profile_type"_object:  // a trapezoid, or limited jerk
      return value == 0 || value == 3;
    case "profile_jerk_use"_object:
      return value == 1 || value == 2;
    case "interpolation_sub_mode_select"_object:      // linear
    case "interpolation_buffer_organization"_object:  // first in, first out
    case "error_history_count"_object:                // cleared
      return value == 0;
    case "interpolation_buffer_record_size"_object:  // one INTEGER32
      return value == 4;
    case "positioning_option_code"_object:
      return value <= 2;
    case "vl_set_point_factor_numerator"_object:
    case "vl_set_point_factor_denominator"_object:
    case "vl_dimension_factor_numerator"_object:
    case "vl_dimension_factor_denominator"_object:
      return value != 0;
    case "touch_probe_function"_object:
      return is_touch_probe_function(value);
    case "touch_probe_source_1"_object:
    case "touch_probe_source_2"_object:  // the drive has no fourth input
      return value != 4;
    case "habit_statusword_bits"_object:
      return (value & ~kMakerBits) == 0;
    case "store_all_parameters"_object:
      return value == kStoreSignature;
    case "restore_all_default_parameters"_object:
      return value == kRestoreSignature;
    default:
      return true;
  }
}

AbortCode check_value(ObjectRow row, std::int64_t value) {
  if (has_meaning(row, value)) return AbortCode::none;
  const bool is_signature =
      row == "store_all_parameters"_object || row == "restore_all_default_parameters"_object;
  return is_signature ? AbortCode::cannot_store_or_transfer : AbortCode::value_range_exceeded;
}

/// @return each value by itself; in a list longer than kSome, runs such as "17 to 30".
std::vector<std::string> parts_of_list(const std::vector<std::int64_t>& values) {
  constexpr std::size_t kSome = 16;
  constexpr std::size_t kShortestRun = 3;
  std::vector<std::string> parts;
  std::size_t first = 0;
  while (first < values.size()) {
    std::size_t end = first + 1;
    while (end < values.size() && values[end] == values[end - 1] + 1) ++end;
    const bool is_run = values.size() > kSome && end - first >= kShortestRun;
    std::string part = std::to_string(values[first]);
    if (is_run) part += " to " + std::to_string(values[end - 1]);
    parts.push_back(std::move(part));
    first = is_run ? end : first + 1;
  }
  return parts;
}

}  // namespace

constinit const std::span<const ObjectDescription> kObjectTable{kObjectRows};
constinit const std::span<const ObjectRow> kStoredRows{kStored};

std::optional<ObjectRow> find_object(ObjectAddress address) noexcept {
  return find_row(address);
}

std::optional<ObjectRow> find_object(std::string_view variable_name) noexcept {
  return find_row(variable_name);
}

const ObjectDescription& describe(ObjectRow row) noexcept {
  ensure(row < kObjectCount, "a row of the dictionary is inside its table");
  return kObjectRows[row];
}

bool has_role(ObjectRow row, Role role) noexcept {
  return describe(row).role == role;
}

bool has_role(ObjectAddress address, Role role) noexcept {
  const auto row = find_object(address);
  return row && has_role(*row, role);
}

std::string_view describe(AbortCode code) noexcept {
  const auto* const found = std::ranges::find(kAbortCodes, code, &AbortCodeRow::code);
  return found == kAbortCodes.end() ? "unknown abort code" : found->words;
}

std::string_view to_string(DataType type) noexcept {
  switch (type) {
    case DataType::integer8:
      return "INTEGER8";
    case DataType::integer16:
      return "INTEGER16";
    case DataType::integer32:
      return "INTEGER32";
    case DataType::unsigned8:
      return "UNS8";
    case DataType::unsigned16:
      return "UNS16";
    case DataType::unsigned32:
      return "UNS32";
  }
  return "";
}

std::string_view to_string(Access access) noexcept {
  return access == Access::read_only ? "RO" : "RW";
}

std::string_view to_string(Effective effective) noexcept {
  switch (effective) {
    case Effective::read_only:
      return "read_only";
    case Effective::immediately:
      return "immediately";
    case Effective::at_set_point:
      return "at_set_point";
    case Effective::at_enable:
      return "at_enable";
  }
  return "unknown";
}

std::string english_units(const ObjectDescription& object) {
  constexpr std::string_view kOpening = "（";
  constexpr std::string_view kUserUnit = "用户单位";  // "user unit"; the unit may follow
  constexpr std::string_view kClosing = "）";
  const std::string_view units = object.units;
  std::string result(units.substr(0, units.find(kOpening)));
  if (const std::size_t found = units.find(kUserUnit); found != std::string_view::npos) {
    std::string_view unit = units.substr(found + kUserUnit.size());
    unit = unit.substr(0, unit.find(kClosing));
    unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
    if (!unit.empty()) result += " (" + std::string(unit) + ")";
  }
  return result;
}

std::string address_text(ObjectAddress address) {
  const std::string index = hex(address.index, 4);
  return address.subindex == 0 ? index : index + ":" + std::to_string(address.subindex);
}

AbortCode check_address(ObjectAddress address) noexcept {
  if (find_object(address)) return AbortCode::none;
  const bool index_exists = std::ranges::any_of(kObjectTable, [address](const auto& row) {
    return row.address.index == address.index;
  });
  return index_exists ? AbortCode::subindex_does_not_exist : AbortCode::object_does_not_exist;
}

AbortCode check_write(ObjectRow row, std::int64_t value) noexcept {
  const ObjectDescription& object = describe(row);
  if (object.access == Access::read_only) return AbortCode::write_of_read_only_object;
  if (value > object.upper_limit) return AbortCode::value_too_high;
  if (value < object.lower_limit) return AbortCode::value_too_low;
  return AbortCode::none;
}

AbortCode check_object_value(ObjectRow row, std::int64_t value) noexcept {
  const AbortCode code = check_write(row, value);
  const bool is_judged =
      code == AbortCode::none || (is_judged_by_meaning(row) && is_within_type(row, value));
  return is_judged ? check_value(row, value) : code;
}

AbortCode check_value_on_modulo_axis(ObjectRow row, std::int64_t value) noexcept {
  const bool may_have_direction =
      row == "positioning_option_code"_object && is_within_type(row, value);
  return check_object_value(
      row, may_have_direction ? value & ~PositioningOption::kDirectionBits : value);
}

std::vector<std::int64_t> few_values(ObjectRow row) {
  constexpr std::int64_t kMostLooked = 65'535;  // the span of a 16-bit object
  constexpr std::size_t kFew = 40;              // enough for shell completion of 6098h
  const ObjectDescription& object = describe(row);
  std::vector<std::int64_t> values;
  const bool is_looked_at =
      object.access == Access::read_write && object.upper_limit - object.lower_limit <= kMostLooked;
  if (!is_looked_at) return values;
  for (std::int64_t value = object.lower_limit; value <= object.upper_limit; ++value) {
    if (check_object_value(row, value) != AbortCode::none) continue;
    if (values.size() == kFew) return {};
    values.push_back(value);
  }
  return values;
}

std::string values_text(ObjectRow row) {
  const ObjectDescription& object = describe(row);
  const std::vector<std::int64_t> values = few_values(row);
  const bool has_gaps = !values.empty() && static_cast<std::int64_t>(values.size()) !=
                                               object.upper_limit - object.lower_limit + 1;
  if (!has_gaps) {
    return std::to_string(object.lower_limit) + " to " + std::to_string(object.upper_limit);
  }
  const std::vector<std::string> parts = parts_of_list(values);
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i != 0) text += i + 1 == parts.size() ? " or " : ", ";
    text += parts[i];
  }
  return text;
}

}  // namespace vdrive
