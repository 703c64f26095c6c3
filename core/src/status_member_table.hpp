// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string_view>
#include <type_traits>
#include <utility>

namespace vdrive {

template <std::size_t kField>
inline constexpr auto kStatusPointer = std::get<kField>(kStatusFields).member;

template <std::size_t kField>
std::int64_t get_status_member(const AxisStatus& status) noexcept {
  return status.*kStatusPointer<kField>;
}

template <std::size_t kField>
void set_status_member(AxisStatus& status, std::int64_t value) noexcept {
  auto& member = status.*kStatusPointer<kField>;
  member = static_cast<std::remove_reference_t<decltype(member)>>(value);
}

template <typename Number>
constexpr DataType data_type_of() noexcept {
  constexpr bool kIsSigned = std::is_signed_v<Number>;
  switch (sizeof(Number)) {
    case 1:
      return kIsSigned ? DataType::integer8 : DataType::unsigned8;
    case 2:
      return kIsSigned ? DataType::integer16 : DataType::unsigned16;
    default:
      static_assert(sizeof(Number) <= 4, "the dictionary has no longer type");
      return kIsSigned ? DataType::integer32 : DataType::unsigned32;
  }
}

template <std::size_t kField>
constexpr StatusMember status_member() {
  constexpr auto kRow = std::get<kField>(kStatusFields);
  const auto row = find_row(kRow.name);
  return {.name = kRow.name,
          .address = row ? kObjectRows[*row].address : ObjectAddress{},
          .data_type = data_type_of<std::remove_cvref_t<decltype(AxisStatus{}.*kRow.member)>>(),
          .is_published = kRow.is_published,
          .value = get_status_member<kField>,
          .set = set_status_member<kField>};
}

/// The rows of kStatusFields together with the data of the dictionary.
inline constexpr auto kStatusMemberTable =
    []<std::size_t... kField>(std::index_sequence<kField...>) {
  return std::array{status_member<kField>()...};
}
(std::make_index_sequence<kStatusMembers>{});

static_assert(std::accumulate(kStatusMemberTable.begin(), kStatusMemberTable.end(), std::size_t{0},
                              [](std::size_t bytes, const StatusMember& member) {
                                return bytes + size_of(member.data_type);
                              }) == sizeof(AxisStatus),
              "each member of AxisStatus has one row, and no gap before it");

}  // namespace vdrive
