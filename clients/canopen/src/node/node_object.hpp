// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace vdrive::canopen {

/// The data types of CiA 301 used in the dictionary of a node, with their numbers in an EDS.
enum class NodeDataType : std::uint16_t {
  integer8 = 0x0002,
  integer16 = 0x0003,
  integer32 = 0x0004,
  unsigned8 = 0x0005,
  unsigned16 = 0x0006,
  unsigned32 = 0x0007,
  visible_string = 0x0009,
};

/// @return the size [bytes] of a number of this type; 0 for visible_string.
[[nodiscard]] constexpr std::uint8_t size_of(NodeDataType type) noexcept {
  switch (type) {
    case NodeDataType::integer8:
    case NodeDataType::unsigned8:
      return 1;
    case NodeDataType::integer16:
    case NodeDataType::unsigned16:
      return 2;
    case NodeDataType::integer32:
    case NodeDataType::unsigned32:
      return 4;
    case NodeDataType::visible_string:
      return 0;
  }
  return 0;
}

/// @param bytes a number of this type in the byte order of frames
[[nodiscard]] constexpr std::int64_t number_of(NodeDataType type,
                                               std::span<const std::uint8_t> bytes) noexcept {
  const bool is_signed = type == NodeDataType::integer8 || type == NodeDataType::integer16 ||
                         type == NodeDataType::integer32;
  return is_signed ? signed_little_endian_number(bytes)
                   : static_cast<std::int64_t>(little_endian_number(bytes));
}

enum class NodeAccess : std::uint8_t { read_only, read_write, write_only, constant };

/// The holder of an object's value.
enum class ObjectOwner : std::uint8_t {
  node,   ///< communication object: the node itself (1000h to 1FFFh, and the :00 of every array and
          ///< record)
  drive,  ///< a row of the core's table: the drive
};

/// Which PDOs may carry an object (CiA 301, 7.5.2.36 and 7.5.2.38).
enum class PdoMapping : std::uint8_t {
  none,
  transmit,  ///< TPDOs only: a value of the drive that no PDO may write
  receive,   ///< RPDOs only: the object is write-only
  both,      ///< RPDOs write it as a set-point, TPDOs show it
};

/// As seen from the node, as in CiA 301.
enum class PdoDirection : std::uint8_t { receive, transmit };

/// @return whether PDOs of this direction may carry an object with this mapping.
[[nodiscard]] constexpr bool allows(PdoMapping mapping, PdoDirection direction) noexcept {
  return mapping == PdoMapping::both ||
         mapping ==
             (direction == PdoDirection::transmit ? PdoMapping::transmit : PdoMapping::receive);
}

/// The structure of an index (CiA 301, table "Object code").
enum class ObjectCode : std::uint8_t { variable = 0x7, array = 0x8, record = 0x9 };

/// One object in the dictionary of a node: the source for SDO, PDO mapping, EDS and documents.
struct NodeObject {
  ObjectAddress address;
  std::string_view name;        ///< ASCII, without ';' and '#'
  std::string_view index_name;  ///< name of the index; for a variable, the name of its :00
  ObjectCode code = ObjectCode::variable;
  NodeDataType data_type = NodeDataType::unsigned32;
  NodeAccess access = NodeAccess::read_only;
  ObjectOwner owner = ObjectOwner::node;
  PdoMapping mapping = PdoMapping::none;
  std::int64_t lower_limit = 0;  ///< no meaning for visible_string
  std::int64_t upper_limit = 0;
  std::int64_t default_value = 0;   ///< of a COB-ID: without the node id if has_node_id
  std::string_view default_text{};  ///< of visible_string
  bool has_node_id = false;         ///< the node id is added to the default ("$NODEID+0x180")
};

/// All objects of a node, by index and sub-index. The drive's objects come from kObjectTable; the
/// others are defined only in the source file of this function. Built once; the texts are static.
[[nodiscard]] std::span<const NodeObject> node_objects();

/// @return the object at `address`; nullptr if there is none.
[[nodiscard]] const NodeObject* find_node_object(ObjectAddress address);

/// @return object_does_not_exist if no object has this index, subindex_does_not_exist if the index
///         has no such sub-index, otherwise none.
[[nodiscard]] AbortCode check_node_address(ObjectAddress address);

/// @return the default of a communication object, with the node id added where `has_node_id`.
[[nodiscard]] std::int64_t default_of(const NodeObject& object, std::uint8_t node_id) noexcept;

/// @param node_id added to the default where `NodeObject::has_node_id`
/// @return the default of a communication object; 0 if the dictionary does not have the object.
[[nodiscard]] std::uint32_t initial_value(ObjectAddress object, std::uint8_t node_id = 0);

/// @param objects rows with an `address`, sorted by it
/// @return the rows, grouped by index.
template <typename Object>
[[nodiscard]] std::vector<std::span<const Object>> by_index(std::span<const Object> objects) {
  std::vector<std::span<const Object>> indices;
  while (!objects.empty()) {
    const auto next = std::ranges::find_if(objects, [&objects](const Object& object) {
      return object.address.index != objects.front().address.index;
    });
    const auto count = static_cast<std::size_t>(next - objects.begin());
    indices.push_back(objects.first(count));
    objects = objects.subspan(count);
  }
  return indices;
}

}  // namespace vdrive::canopen
