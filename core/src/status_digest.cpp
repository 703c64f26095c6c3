// SPDX-License-Identifier: Apache-2.0
#include "vdrive/status_digest.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>

namespace vdrive {
namespace {

template <auto kMember>
std::int64_t get(const AxisStatus& status) noexcept {
  return status.*kMember;
}

template <auto kMember>
constexpr StatusMember member(std::string_view name) {
  const auto row = find_object(name);
  return {name, row ? describe(*row).address : ObjectAddress{}, get<kMember>};
}

constexpr std::array<StatusMember, kStatusMembers> kMembers{{
    member<&AxisStatus::position_demand_value>("position_demand_value"),
    member<&AxisStatus::load_position_actual_value>("load_position_actual_value"),
    member<&AxisStatus::load_position_error_value>("load_position_error_value"),
    member<&AxisStatus::motor_position_actual_value>("motor_position_actual_value"),
    member<&AxisStatus::motor_position_error_value>("motor_position_error_value"),
    member<&AxisStatus::velocity_demand_value>("velocity_demand_value"),
    member<&AxisStatus::load_velocity_actual_value>("load_velocity_actual_value"),
    member<&AxisStatus::load_velocity_error_value>("load_velocity_error_value"),
    member<&AxisStatus::motor_velocity_actual_value>("motor_velocity_actual_value"),
    member<&AxisStatus::motor_velocity_error_value>("motor_velocity_error_value"),
    member<&AxisStatus::current_error_value>("current_error_value"),
    member<&AxisStatus::current_actual_value>("current_actual_value"),
    member<&AxisStatus::torque_actual_value>("torque_actual_value"),
    member<&AxisStatus::torque_demand>("torque_demand"),
    member<&AxisStatus::ds402_statusword>("ds402_statusword"),
    member<&AxisStatus::ds402_controlword>("ds402_controlword"),
    member<&AxisStatus::error_code>("error_code"),
    member<&AxisStatus::op_mode_actual>("op_mode_actual"),
    member<&AxisStatus::motor_op_status>("motor_op_status"),
    member<&AxisStatus::error_register>("error_register"),
    member<&AxisStatus::digital_inputs>("digital_inputs"),
    member<&AxisStatus::ignored_set_points>("ignored_set_points"),
    member<&AxisStatus::fault_count>("fault_count"),
}};

constexpr std::uint64_t kPrime = 1099511628211ULL;  // FNV-1a, over words of 64 bits
constexpr std::uint64_t kOffset = 14695981039346656037ULL;

/// SplitMix64 (Steele, Lea and Flood, 2014): a bijection whose results look random.
constexpr std::uint64_t scramble(std::uint64_t value) noexcept {
  value += 0x9E3779B97F4A7C15ULL;
  value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  value = (value ^ (value >> 27U)) * 0x94D049BB133111EBULL;
  return value ^ (value >> 31U);
}

constexpr std::uint32_t fold(std::uint64_t value) noexcept {
  return static_cast<std::uint32_t>(value ^ (value >> 32U));
}

/// A status image as words.
using Words = std::array<std::uint64_t, (sizeof(AxisStatus) + 7) / 8>;

static_assert(std::has_unique_object_representations_v<AxisStatus>, "no padding in the check");

/// Odd factors, by which no difference of one word vanishes.
constexpr Words kKeys = [] {
  Words keys{};
  for (std::size_t word = 0; word < keys.size(); ++word) {
    keys[word] = scramble(word) | 1U;
  }
  return keys;
}();

std::uint64_t row_of(const AxisStatus& status) noexcept {
  Words words{};
  std::memcpy(words.data(), &status, sizeof(status));
  std::uint64_t sum = 0;
  for (std::size_t word = 0; word < words.size(); ++word) {
    sum += words[word] * kKeys[word];
  }
  return scramble(sum);
}

constexpr std::size_t kFirstNarrow = 11;  // the members before it and the last two have 32 bits
constexpr std::size_t kColumns = 24;      // the members, rounded up to whole vectors

/// Every member in a word of its own.
using Columns = std::array<std::uint32_t, kColumns>;

void widen(const AxisStatus& s, Columns& columns) noexcept {
  static_assert(offsetof(AxisStatus, current_actual_value) == kFirstNarrow * sizeof(std::uint32_t));
  const auto word = [](auto value) {
    return static_cast<std::uint32_t>(value);
  };
  std::memcpy(columns.data(), &s, kFirstNarrow * sizeof(std::uint32_t));
  columns[11] = word(s.current_actual_value);
  columns[12] = word(s.torque_actual_value);
  columns[13] = word(s.torque_demand);
  columns[14] = word(s.ds402_statusword);
  columns[15] = word(s.ds402_controlword);
  columns[16] = word(s.error_code);
  columns[17] = word(s.op_mode_actual);
  columns[18] = word(s.motor_op_status);
  columns[19] = word(s.error_register);
  columns[20] = word(s.digital_inputs);
  columns[21] = s.ignored_set_points;
  columns[22] = s.fault_count;
  columns[23] = 0;
}

}  // namespace

std::span<const StatusMember, kStatusMembers> status_members() noexcept {
  return kMembers;
}

StatusDigest digest_of(std::span<const AxisStatus> statuses, std::size_t axes_per_row,
                       std::span<std::uint32_t> rows) noexcept {
  Columns sums{};
  std::uint64_t image = kOffset;
  std::uint64_t row = kOffset;
  std::size_t left_in_row = axes_per_row;
  std::size_t row_number = 0;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): filled before it is read
  Columns columns;
  for (std::size_t axis = 0; axis < statuses.size(); ++axis) {
    widen(statuses[axis], columns);
    for (std::size_t column = 0; column < kColumns; ++column) {
      sums[column] = sums[column] * 31U + columns[column];  // 31 is odd: nothing is shifted out
    }
    const std::uint64_t axis_row = row_of(statuses[axis]);
    image = (image ^ axis_row) * kPrime;
    row = (row ^ axis_row) * kPrime;
    --left_in_row;
    if (left_in_row == 0 || axis + 1 == statuses.size()) {
      if (row_number < rows.size()) {
        rows[row_number] = fold(row);
      }
      ++row_number;
      row = kOffset;
      left_in_row = axes_per_row;
    }
  }
  StatusDigest digest{.image = image};
  std::copy_n(sums.begin(), kStatusMembers, digest.members.begin());
  return digest;
}

}  // namespace vdrive
