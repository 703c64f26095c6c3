// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive_messages_description.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

namespace vdrive::wire {

/// @return the offset of a published member in a status image [bytes]; nothing for any other name.
constexpr std::optional<std::size_t> place_in_image(std::string_view name) {
  std::optional<std::size_t> found;
  std::apply(
      [&](const auto&... fields) {
        const auto look_at = [&]<typename Number>(const StatusField<Number>& field) {
          if (!field.is_published || field.name != name) return;
          AxisStatus status;
          status.*field.member = static_cast<Number>(-1);  // all bits 1
          const auto image = std::bit_cast<std::array<std::byte, sizeof(AxisStatus)>>(status);
          found =
              static_cast<std::size_t>(std::ranges::find(image, std::byte{0xFF}) - image.begin());
        };
        (look_at(fields), ...);
      },
      kStatusFields);
  return found;
}

/// Calls `visit(member, in_message)` with the two member pointers of each member of the status
/// image that is also in the IDL. A published member that the IDL does not have does not compile.
template <typename Visit>
constexpr void for_each_status_member(const Visit& visit) {
  [&]<std::size_t... kField>(std::index_sequence<kField...>) {
    const auto visit_one = [&]<std::size_t kIndex>(std::integral_constant<std::size_t, kIndex>) {
      constexpr auto kRow = std::get<kIndex>(kStatusFields);
      if constexpr (kRow.is_published) {
        constexpr std::size_t kInMessage = member_index<msg::AxisStatus>(kRow.name);
        visit(kRow.member, std::get<kInMessage>(Description<msg::AxisStatus>::kMembers).pointer);
      }
    };
    (visit_one(std::integral_constant<std::size_t, kField>{}), ...);
  }
  (std::make_index_sequence<kStatusMembers>{});
}

}  // namespace vdrive::wire
