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

/// Data types of CiA 301 that the dictionary of a node has, by the number that an EDS writes.
enum class NodeDataType : std::uint16_t {
  integer8 = 0x0002,
  integer16 = 0x0003,
  integer32 = 0x0004,
  unsigned8 = 0x0005,
  unsigned16 = 0x0006,
  unsigned32 = 0x0007,
  visible_string = 0x0009,
};

/// @return bytes of a number of this type; 0 for visible_string.
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

/// @param bytes of a number of this type, as frames have them
[[nodiscard]] constexpr std::int64_t number_of(NodeDataType type,
                                               std::span<const std::uint8_t> bytes) noexcept {
  const bool is_signed = type == NodeDataType::integer8 || type == NodeDataType::integer16 ||
                         type == NodeDataType::integer32;
  return is_signed ? signed_little_endian_number(bytes)
                   : static_cast<std::int64_t>(little_endian_number(bytes));
}

enum class NodeAccess : std::uint8_t { read_only, read_write, write_only, constant };

/// Whose register an object is.
enum class ObjectOwner : std::uint8_t {
  node,   ///< communication object: the node itself has it (1000h to 1FFFh, all :00 counts)
  drive,  ///< a row of the core's table: the drive has it
};

/// Where an object may be mapped (CiA 301, 7.5.2.36 and 7.5.2.38).
enum class PdoMapping : std::uint8_t {
  none,
  transmit,  ///< into TPDOs: the drive has it, and no PDO may bring it
  receive,   ///< into RPDOs: it is write-only
  both,      ///< a set-point of the drive may bring it, and a TPDO shows it
};

/// Seen from the node, as CiA 301 does.
enum class PdoDirection : std::uint8_t { receive, transmit };

/// @return whether PDOs of this direction may carry what is mapped so.
[[nodiscard]] constexpr bool allows(PdoMapping mapping, PdoDirection direction) noexcept {
  return mapping == PdoMapping::both ||
         mapping ==
             (direction == PdoDirection::transmit ? PdoMapping::transmit : PdoMapping::receive);
}

/// Shape of the index that an object belongs to (CiA 301, table "Object code").
enum class ObjectCode : std::uint8_t { variable = 0x7, array = 0x8, record = 0x9 };

/// One object of the dictionary of a node: what SDO, PDO mapping, EDS and documents read.
struct NodeObject {
  ObjectAddress address;
  std::string_view name;        ///< ASCII, without ';' and '#'
  std::string_view index_name;  ///< name of the whole index; that of :00 of a variable
  ObjectCode code = ObjectCode::variable;
  NodeDataType data_type = NodeDataType::unsigned32;
  NodeAccess access = NodeAccess::read_only;
  ObjectOwner owner = ObjectOwner::node;
  PdoMapping mapping = PdoMapping::none;
  std::int64_t lower_limit = 0;  ///< no meaning for visible_string
  std::int64_t upper_limit = 0;
  std::int64_t default_value = 0;   ///< of a COB-ID: without the node id where has_node_id
  std::string_view default_text{};  ///< of visible_string
  bool has_node_id = false;         ///< the default has the node id added ("$NODEID+0x180")
};

/// Every object of a node, by index and sub-index. The drive's rows are made of kObjectTable, the
/// others stand once in the source of this function, and nowhere else. Made once; the texts are
/// static.
[[nodiscard]] std::span<const NodeObject> node_objects();

/// @return the object at `address`; nothing when there is none.
[[nodiscard]] const NodeObject* find_node_object(ObjectAddress address);

/// @return object_does_not_exist when no object has this index, subindex_does_not_exist when the
///         index has no such sub-index, else none.
[[nodiscard]] AbortCode check_node_address(ObjectAddress address);

/// @return the default of a communication object in a node, its node id added where it has one.
[[nodiscard]] std::int64_t default_of(const NodeObject& object, std::uint8_t node_id) noexcept;

/// @param node_id is added where the default has it (`NodeObject::has_node_id`)
/// @return the default of a communication object; 0 when the dictionary does not have the object.
[[nodiscard]] std::uint32_t initial_value(ObjectAddress object, std::uint8_t node_id = 0);

/// @param objects rows with an `address`, sorted by it
/// @return the rows of each index.
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
