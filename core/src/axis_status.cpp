// SPDX-License-Identifier: Apache-2.0
#include "vdrive/axis_status.hpp"

#include "status_member_table.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>

namespace vdrive {

std::span<const StatusMember, kStatusMembers> status_members() noexcept {
  return kStatusMemberTable;
}

std::optional<std::int64_t> value_of(const AxisStatus& status, ObjectRow row) noexcept {
  ensure(row < kObjectCount, "a row of the dictionary is inside its table");
  const ObjectAddress address = kObjectRows[row].address;
  const auto* const member =
      std::ranges::find_if(kStatusMemberTable, [&](const StatusMember& candidate) {
        return candidate.is_published && candidate.address == address;
      });
  if (member == kStatusMemberTable.end()) return std::nullopt;
  return member->value(status);
}

}  // namespace vdrive
