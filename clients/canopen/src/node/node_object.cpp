// SPDX-License-Identifier: Apache-2.0
#include "node/node_object.hpp"

#include "node/cob_id.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace vdrive::canopen {
namespace {

/// The common part of the objects of one index (CiA 301, 7.4.3).
struct NodeIndex {
  std::uint16_t index = 0;
  std::string_view name{};
  ObjectCode code = ObjectCode::variable;
};

/// @return the type of the same name.
constexpr NodeDataType node_type_of(DataType type) {
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

/// @return a numeric object of the node itself that cannot be mapped; its limits are those of its
///         type.
constexpr NodeObject number_object(const NodeIndex& index, std::uint8_t subindex,
                                   std::string_view name, DataType type, NodeAccess access,
                                   std::int64_t default_value = 0) {
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

/// @return :00 of an array or a record with a fixed set of objects.
constexpr NodeObject highest_subindex_object(const NodeIndex& index, std::uint8_t highest) {
  return number_object(index, 0, "Highest sub-index supported", DataType::unsigned8,
                       NodeAccess::constant, highest);
}

// ---- communication objects ---------------------------------------------------------------------
// The node's own objects that are not in the core's table (CiA 301, 7.5.2), by index and sub-index.
// 100Ch and 100Dh (node guarding) are absent.

constexpr NodeObject variable_object(std::uint16_t index, std::string_view name, DataType type,
                                     std::int64_t default_value) {
  const NodeIndex variable{index, name, ObjectCode::variable};
  return number_object(variable, 0, name, type, NodeAccess::read_write, default_value);
}

constexpr NodeObject constant_text(std::uint16_t index, std::string_view name,
                                   std::string_view text) {
  NodeObject object;
  object.address = {.index = index, .subindex = 0};
  object.name = name;
  object.index_name = name;
  object.data_type = NodeDataType::visible_string;
  object.access = NodeAccess::constant;
  object.default_text = text;
  return object;
}

constexpr NodeObject limited_to(std::int64_t upper_limit, NodeObject object) {
  object.upper_limit = upper_limit;
  return object;
}

constexpr NodeObject with_node_id(NodeObject object) {
  object.has_node_id = true;
  return object;
}

constexpr NodeIndex kConsumerHeartbeat{0x1016, "Consumer heartbeat time", ObjectCode::array};
constexpr NodeIndex kVerifyConfiguration{0x1020, "Verify configuration", ObjectCode::array};
constexpr NodeIndex kErrorBehavior{0x1029, "Error behavior", ObjectCode::array};
constexpr NodeIndex kSdoServer{0x1200, "SDO server parameter", ObjectCode::record};

constexpr NodeObject consumer_heartbeat(std::uint8_t subindex, std::string_view name) {
  return number_object(kConsumerHeartbeat, subindex, name, DataType::unsigned32,
                       NodeAccess::read_write);
}

constexpr NodeObject sdo_server_cob_id(std::uint8_t subindex, std::string_view name,
                                       std::int64_t cob_id) {
  return with_node_id(number_object(kSdoServer, subindex, name, DataType::unsigned32,
                                    NodeAccess::constant, cob_id));
}

/// 1000h to 1FFFh without the PDOs. 100Ah has no default: it is the version of the program.
constexpr std::array kGeneralObjects{
    variable_object(0x1005, "COB-ID SYNC message", DataType::unsigned32, 0x80),
    variable_object(0x1006, "Communication cycle period", DataType::unsigned32, 0),
    variable_object(0x1007, "Synchronous window length", DataType::unsigned32, 0),
    constant_text(0x1008, "Manufacturer device name", "vdrive"),
    constant_text(0x1009, "Manufacturer hardware version", "1"),
    constant_text(0x100A, "Manufacturer software version", ""),
    with_node_id(variable_object(0x1014, "COB-ID EMCY", DataType::unsigned32, kEmergencyId)),
    variable_object(0x1015, "Inhibit time EMCY", DataType::unsigned16, 0),
    highest_subindex_object(kConsumerHeartbeat, 4),
    consumer_heartbeat(1, "Consumer heartbeat time 1"),
    consumer_heartbeat(2, "Consumer heartbeat time 2"),
    consumer_heartbeat(3, "Consumer heartbeat time 3"),
    consumer_heartbeat(4, "Consumer heartbeat time 4"),
    variable_object(0x1017, "Producer heartbeat time", DataType::unsigned16, 0),
    limited_to(
        240, variable_object(0x1019, "Synchronous counter overflow value", DataType::unsigned8, 0)),
    highest_subindex_object(kVerifyConfiguration, 2),
    number_object(kVerifyConfiguration, 1, "Configuration date", DataType::unsigned32,
                  NodeAccess::read_write),
    number_object(kVerifyConfiguration, 2, "Configuration time", DataType::unsigned32,
                  NodeAccess::read_write),
    highest_subindex_object(kErrorBehavior, 1),
    limited_to(2, number_object(kErrorBehavior, 1, "Communication error", DataType::unsigned8,
                                NodeAccess::read_write)),
    highest_subindex_object(kSdoServer, 2),
    sdo_server_cob_id(1, "COB-ID client to server (rx)", kSdoRequestId),
    sdo_server_cob_id(2, "COB-ID server to client (tx)", kSdoResponseId),
};

/// A PDO after power-up.
struct PdoRow {
  NodeIndex parameters;
  NodeIndex mapping;
  std::int64_t cob_id = 0;  ///< predefined connection set (CiA 301, 7.3.5), without the node id
  std::array<ObjectAddress, 2> mapped{};  ///< index 0 = none
  std::int64_t inhibit_time = 0;          ///< of a transmit PDO [100 us]
};

constexpr std::size_t kPdosOfAKind = 4;
using PdoRows = std::array<PdoRow, kPdosOfAKind>;

// The PDO mapping of CiA 402-3; the fourth RPDO carries the target velocity.
constexpr PdoRows kReceiveRows{{
    {{0x1400, "RPDO 1 communication parameter", ObjectCode::record},
     {0x1600, "RPDO 1 mapping parameter", ObjectCode::record},
     0x200,
     {{{0x6040, 0x00}, {}}},
     0},
    {{0x1401, "RPDO 2 communication parameter", ObjectCode::record},
     {0x1601, "RPDO 2 mapping parameter", ObjectCode::record},
     0x300,
     {{{0x6040, 0x00}, {0x6060, 0x00}}},
     0},
    {{0x1402, "RPDO 3 communication parameter", ObjectCode::record},
     {0x1602, "RPDO 3 mapping parameter", ObjectCode::record},
     0x400,
     {{{0x6040, 0x00}, {0x607A, 0x00}}},
     0},
    {{0x1403, "RPDO 4 communication parameter", ObjectCode::record},
     {0x1603, "RPDO 4 mapping parameter", ObjectCode::record},
     0x500,
     {{{0x6040, 0x00}, {0x60FF, 0x00}}},
     0},
}};

// Position and velocity change in every tick: without inhibit times they would flood the bus.
constexpr PdoRows kTransmitRows{{
    {{0x1800, "TPDO 1 communication parameter", ObjectCode::record},
     {0x1A00, "TPDO 1 mapping parameter", ObjectCode::record},
     0x180,
     {{{0x6041, 0x00}, {}}},
     0},
    {{0x1801, "TPDO 2 communication parameter", ObjectCode::record},
     {0x1A01, "TPDO 2 mapping parameter", ObjectCode::record},
     0x280,
     {{{0x6041, 0x00}, {0x6061, 0x00}}},
     0},
    {{0x1802, "TPDO 3 communication parameter", ObjectCode::record},
     {0x1A02, "TPDO 3 mapping parameter", ObjectCode::record},
     0x380,
     {{{0x6041, 0x00}, {0x6064, 0x00}}},
     100},
    {{0x1803, "TPDO 4 communication parameter", ObjectCode::record},
     {0x1A03, "TPDO 4 mapping parameter", ObjectCode::record},
     0x480,
     {{{0x6041, 0x00}, {0x606C, 0x00}}},
     100},
}};

/// Event-driven, as the device profile defines (CiA 301, 7.5.2.35 and 7.5.2.37).
constexpr std::int64_t kEventDriven = 255;

constexpr NodeObject pdo_parameter(const PdoRow& pdo, std::uint8_t subindex, std::string_view name,
                                   DataType type, std::int64_t default_value = 0) {
  return number_object(pdo.parameters, subindex, name, type, NodeAccess::read_write, default_value);
}

constexpr std::array<NodeObject, 4> receive_parameters(const PdoRow& pdo) {
  return {{
      highest_subindex_object(pdo.parameters, 5),
      with_node_id(pdo_parameter(pdo, 1, "COB-ID used by RPDO", DataType::unsigned32, pdo.cob_id)),
      pdo_parameter(pdo, 2, "Transmission type", DataType::unsigned8, kEventDriven),
      pdo_parameter(pdo, 5, "Event timer", DataType::unsigned16),
  }};
}

constexpr std::array<NodeObject, 6> transmit_parameters(const PdoRow& pdo) {
  return {{
      highest_subindex_object(pdo.parameters, 6),
      with_node_id(pdo_parameter(pdo, 1, "COB-ID used by TPDO", DataType::unsigned32, pdo.cob_id)),
      pdo_parameter(pdo, 2, "Transmission type", DataType::unsigned8, kEventDriven),
      pdo_parameter(pdo, 3, "Inhibit time", DataType::unsigned16, pdo.inhibit_time),
      pdo_parameter(pdo, 5, "Event timer", DataType::unsigned16),
      limited_to(240, pdo_parameter(pdo, 6, "SYNC start value", DataType::unsigned8)),
  }};
}

constexpr std::array<std::string_view, 8> kMappedNames{
    "Application object 1", "Application object 2", "Application object 3", "Application object 4",
    "Application object 5", "Application object 6", "Application object 7", "Application object 8"};

/// @return index, sub-index and length [bits] of an object of the drive, encoded as in a mapping
///         parameter (CiA 301, 7.5.2.36).
constexpr std::int64_t mapping_entry(ObjectAddress address) {
  const ObjectDescription& object = kObjectRows[*find_row(address)];
  return std::int64_t{address.index} * 0x10000 + std::int64_t{address.subindex} * 0x100 +
         std::int64_t{size_of(object.data_type)} * 8;
}

constexpr std::array<NodeObject, kMappedNames.size() + 1> mapping_parameters(const PdoRow& pdo) {
  std::array<NodeObject, kMappedNames.size() + 1> objects{};
  const auto add = [&](std::uint8_t subindex, std::string_view name, DataType type,
                       std::int64_t default_value) {
    objects[subindex] =
        number_object(pdo.mapping, subindex, name, type, NodeAccess::read_write, default_value);
  };
  add(0, "Number of mapped application objects in PDO", DataType::unsigned8, 0);
  objects[0].upper_limit = static_cast<std::int64_t>(kMappedNames.size());
  for (std::size_t i = 0; i < kMappedNames.size(); ++i) {
    const ObjectAddress mapped = i < pdo.mapped.size() ? pdo.mapped[i] : ObjectAddress{};
    const bool is_used = mapped.index != 0;
    objects[0].default_value += is_used ? 1 : 0;
    add(static_cast<std::uint8_t>(i + 1), kMappedNames[i], DataType::unsigned32,
        is_used ? mapping_entry(mapped) : 0);
  }
  return objects;
}

template <std::size_t... kSizes>
constexpr auto joined(const std::array<NodeObject, kSizes>&... parts) {
  std::array<NodeObject, (kSizes + ...)> all{};
  auto next = all.begin();
  ((next = std::copy(parts.begin(), parts.end(), next)), ...);
  return all;
}

template <std::size_t kSize>
constexpr auto of_each(const PdoRows& pdos,
                       std::array<NodeObject, kSize> (*objects_of)(const PdoRow& pdo)) {
  return joined(objects_of(pdos[0]), objects_of(pdos[1]), objects_of(pdos[2]), objects_of(pdos[3]));
}

constexpr auto kCommunicationObjects =
    joined(kGeneralObjects, of_each(kReceiveRows, receive_parameters),
           of_each(kReceiveRows, mapping_parameters), of_each(kTransmitRows, transmit_parameters),
           of_each(kTransmitRows, mapping_parameters));

static_assert(std::ranges::is_sorted(kCommunicationObjects, {}, &NodeObject::address),
              "communication objects stand by index and sub-index");

// ---- objects of the drive ----------------------------------------------------------------------

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

/// Indices whose name and code cannot be derived from the rows: all types are equal, but the
/// standard defines a record.
constexpr std::array kNamedIndices{
    NodeIndex{0x1018, "Identity Object", ObjectCode::record},
};

/// Write-only in CiA 402-2. Sessions of the bench may read them.
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

/// The drive's objects below this index are those of CiA 301, such as the identity. They cannot be
/// mapped, except the error register (1001h), which the status contains.
constexpr std::uint16_t kFirstOfProfile = 0x2000;

PdoMapping mapping_of_row(const ObjectDescription& row) {
  if (is_in_status(row.address)) return PdoMapping::transmit;
  if (row.access == Access::read_only) {
    return row.address.index < kFirstOfProfile ? PdoMapping::none : PdoMapping::transmit;
  }
  // A master means a store or clear once, but a PDO would repeat it in each cycle.
  const bool is_once = row.change == Change::memory || row.change == Change::history;
  if (is_once) return PdoMapping::none;
  return access_of_row(row) == NodeAccess::write_only ? PdoMapping::receive : PdoMapping::both;
}

/// @return the words that all names start with, such as "Homing Speed"; the first name if there are
///         none.
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
  std::vector<NodeObject> objects(kCommunicationObjects.begin(), kCommunicationObjects.end());
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

std::uint32_t initial_value(ObjectAddress object, std::uint8_t node_id) {
  const NodeObject* const found = find_node_object(object);
  return found == nullptr ? 0U : static_cast<std::uint32_t>(default_of(*found, node_id));
}

}  // namespace vdrive::canopen
