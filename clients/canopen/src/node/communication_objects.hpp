// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/object_types.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <span>
#include <string_view>

namespace vdrive::canopen {

/// What the objects of one index have in common (CiA 301, 7.4.3).
struct NodeIndex {
  std::uint16_t index = 0;
  std::string_view name{};
  ObjectCode code = ObjectCode::variable;
};

/// @return the type of the same name.
[[nodiscard]] constexpr NodeDataType node_type_of(DataType type) noexcept {
  switch (type) {
    case DataType::integer8:
      return NodeDataType::integer8;
    case DataType::integer16:
      return NodeDataType::integer16;
    case DataType::integer32:
      return NodeDataType::integer32;
    case DataType::unsigned8:
      return NodeDataType::unsigned8;
    case DataType::unsigned16:
      return NodeDataType::unsigned16;
    case DataType::unsigned32:
      return NodeDataType::unsigned32;
  }
  return NodeDataType::unsigned32;
}

/// @return a number of the node itself that no PDO carries; its limits are those of its type.
[[nodiscard]] constexpr NodeObject number_object(const NodeIndex& index, std::uint8_t subindex,
                                                 std::string_view name, DataType type,
                                                 NodeAccess access,
                                                 std::int64_t default_value = 0) noexcept {
  const TypeRange range = range_of(type);
  NodeObject object;
  object.address = {.index = index.index, .subindex = subindex};
  object.name = name;
  object.index_name = index.name;
  object.code = index.code;
  object.data_type = node_type_of(type);
  object.access = access;
  object.lower_limit = range.lowest;
  object.upper_limit = range.highest;
  object.default_value = default_value;
  return object;
}

/// @return :00 of an array or a record whose objects are always there.
[[nodiscard]] constexpr NodeObject highest_subindex_object(const NodeIndex& index,
                                                           std::uint8_t highest) noexcept {
  return number_object(index, 0, "Highest sub-index supported", DataType::unsigned8,
                       NodeAccess::constant, highest);
}

/// The communication objects that a node has beside those of the core's table (CiA 301, 7.5.2), by
/// index and sub-index: each stands once in the source of this function, and nowhere else. 100Ch
/// and 100Dh (node guarding) are absent.
[[nodiscard]] std::span<const NodeObject> communication_objects() noexcept;

}  // namespace vdrive::canopen
