// SPDX-License-Identifier: Apache-2.0
#include "node/node_object.hpp"

#include "node/by_index.hpp"
#include "node/communication_objects.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace vdrive::canopen {
namespace {

/// Rows of the core's table.
using DriveRows = std::span<const ObjectDescription>;

constexpr bool fits_data_sheet(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return c >= ' ' && c <= '~' && c != ';' && c != '#';
  });
}

static_assert(std::ranges::all_of(kObjectRows,
                                  [](const ObjectDescription& row) {
                                    return fits_data_sheet(row.name);
                                  }),
              "an EDS has ASCII, and begins comments with ; and #");

/// Indices whose name and code the rows do not show: their types are equal, and the standard has a
/// record.
constexpr std::array kNamedIndices{
    NodeIndex{0x1018, "Identity Object", ObjectCode::record},
};

/// Which CiA 402-2 has as write-only. Sessions of the bench may read them.
constexpr std::array kWriteOnly{ObjectAddress{0x60C4, 0x05}, ObjectAddress{0x60C4, 0x06}};

NodeAccess access_of_row(const ObjectDescription& row) {
  if (std::ranges::find(kWriteOnly, row.address) != kWriteOnly.end()) return NodeAccess::write_only;
  return row.access == Access::read_only ? NodeAccess::read_only : NodeAccess::read_write;
}

bool is_in_status(ObjectAddress address) {
  return std::ranges::any_of(status_members(), [address](const StatusMember& member) {
    return member.is_published && member.address == address;
  });
}

/// What CiA 301 has of the drive, such as its identity, is mapped into no PDO; the error register
/// (1001h) is, which the status has.
constexpr std::uint16_t kFirstOfProfile = 0x2000;

PdoMapping mapping_of_row(const ObjectDescription& row) {
  if (is_in_status(row.address)) return PdoMapping::transmit;
  if (row.access == Access::read_only) {
    return row.address.index < kFirstOfProfile ? PdoMapping::none : PdoMapping::transmit;
  }
  // A PDO would store or clear in each cycle what a master means to store or clear once.
  const bool is_once = row.change == Change::memory || row.change == Change::history;
  if (is_once) return PdoMapping::none;
  return access_of_row(row) == NodeAccess::write_only ? PdoMapping::receive : PdoMapping::both;
}

/// @return the words that all names begin with, such as "Homing Speed"; the first name where there
///         are none.
std::string_view common_words(DriveRows rows) {
  std::string_view words = rows.front().name;
  const auto begins = [&words](const ObjectDescription& row) {
    const std::string_view rest = row.name.substr(std::min(words.size(), row.name.size()));
    return row.name.starts_with(words) && (rest.empty() || rest.starts_with(' '));
  };
  while (!words.empty() && !std::ranges::all_of(rows, begins)) {
    const std::size_t space = words.rfind(' ');
    words = words.substr(0, space == std::string_view::npos ? 0 : space);
  }
  return words.empty() ? rows.front().name : words;
}

/// @param rows all of one index
NodeIndex drive_index(DriveRows rows) {
  const ObjectDescription& first = rows.front();
  const std::uint16_t index = first.address.index;
  const bool has_count = first.address.subindex == 0;
  if (has_count && rows.size() == 1) return {index, first.name, ObjectCode::variable};
  const auto* const named = std::ranges::find(kNamedIndices, index, &NodeIndex::index);
  if (named != kNamedIndices.end()) return *named;
  const DriveRows members = rows.subspan(has_count ? 1U : 0U);
  const bool is_uniform = std::ranges::all_of(members, [&members](const ObjectDescription& row) {
    return row.data_type == members.front().data_type;
  });
  return {index, common_words(members), is_uniform ? ObjectCode::array : ObjectCode::record};
}

NodeObject drive_object(const NodeIndex& index, const ObjectDescription& row) {
  return {.address = row.address,
          .name = row.name,
          .index_name = index.name,
          .code = index.code,
          .data_type = node_type_of(row.data_type),
          .access = access_of_row(row),
          .owner = ObjectOwner::drive,
          .mapping = mapping_of_row(row),
          .lower_limit = row.lower_limit,
          .upper_limit = row.upper_limit,
          .default_value = row.default_value};
}

/// @param rows all of one index
void append_index(DriveRows rows, std::vector<NodeObject>& objects) {
  const NodeIndex index = drive_index(rows);
  if (rows.front().address.subindex != 0) {
    objects.push_back(highest_subindex_object(index, rows.back().address.subindex));
  }
  for (const ObjectDescription& row : rows) objects.push_back(drive_object(index, row));
}

std::vector<NodeObject> make_node_objects() {
  const std::span<const NodeObject> own = communication_objects();
  std::vector<NodeObject> objects(own.begin(), own.end());
  for (const DriveRows rows : by_index(DriveRows(kObjectTable))) append_index(rows, objects);
  std::ranges::sort(objects, {}, &NodeObject::address);
  return objects;
}

}  // namespace

std::span<const NodeObject> node_objects() {
  static const std::vector<NodeObject> objects = make_node_objects();
  return objects;
}

const NodeObject* find_node_object(ObjectAddress address) {
  const std::span<const NodeObject> objects = node_objects();
  const auto found = std::ranges::lower_bound(objects, address, {}, &NodeObject::address);
  return found != objects.end() && found->address == address ? &*found : nullptr;
}

AbortCode check_node_address(ObjectAddress address) {
  if (find_node_object(address) != nullptr) return AbortCode::none;
  const bool index_exists =
      std::ranges::any_of(node_objects(), [address](const NodeObject& object) {
        return object.address.index == address.index;
      });
  return index_exists ? AbortCode::subindex_does_not_exist : AbortCode::object_does_not_exist;
}

std::int64_t default_of(const NodeObject& object, std::uint8_t node_id) noexcept {
  return object.default_value + (object.has_node_id ? node_id : 0);
}

}  // namespace vdrive::canopen
