// SPDX-License-Identifier: Apache-2.0
#include "node/electronic_data_sheet.hpp"

#include "node/node_object.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace vdrive::literals;

constexpr ObjectAddress kVersionObject{0x100A, 0};

/// The objects of one index.
using IndexObjects = std::span<const NodeObject>;

std::uint16_t index_of_objects(IndexObjects objects) {
  return objects.front().address.index;
}

/// Builds the text of an EDS.
class SheetText {
 public:
  void begin_section(std::string_view name) {
    if (!text_.empty()) text_ += '\n';
    text_.append("[").append(name).append("]\n");
  }

  void add(std::string_view key, std::string_view value) {
    text_.append(key).append("=").append(value).append("\n");
  }

  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

/// Codes, COB-IDs and mappings are written in hex, everything else in decimal: readers disagree
/// about negative hex numbers; some take the digits as two's complement, others expect a sign.
std::string sheet_number(const NodeObject& object, std::int64_t value) {
  constexpr std::size_t kDigits = 8;
  const bool is_hex = object.data_type == NodeDataType::unsigned32 && object.address.index < 0x2000;
  return is_hex ? hex(static_cast<std::uint64_t>(value), kDigits) : std::to_string(value);
}

std::string sheet_default(const NodeObject& object) {
  if (object.data_type == NodeDataType::visible_string) return std::string(object.default_text);
  if (object.has_node_id) {
    return "$NODEID+" + hex(static_cast<std::uint64_t>(object.default_value), 1);
  }
  return sheet_number(object, object.default_value);
}

/// @return whether the limits of the object are narrower than those of its type.
bool has_own_limits(const NodeObject& object) {
  if (object.data_type == NodeDataType::visible_string) return false;
  const bool is_signed = object.data_type <= NodeDataType::integer32;
  const std::int64_t values = std::int64_t{1} << (8U * size_of(object.data_type));
  const std::int64_t lowest = is_signed ? -(values / 2) : 0;
  return object.lower_limit != lowest || object.upper_limit != lowest + values - 1;
}

std::string object_code_text(ObjectCode code) {
  return hex(static_cast<std::uint64_t>(code), 1);
}

void add_object_keys(const NodeObject& object, SheetText& sheet) {
  constexpr std::size_t kTypeDigits = 4;
  sheet.add("ParameterName", object.name);
  sheet.add("ObjectType", object_code_text(ObjectCode::variable));
  sheet.add("DataType", hex(static_cast<std::uint64_t>(object.data_type), kTypeDigits));
  sheet.add("AccessType", access_text(object));
  if (has_own_limits(object)) {
    sheet.add("LowLimit", sheet_number(object, object.lower_limit));
    sheet.add("HighLimit", sheet_number(object, object.upper_limit));
  }
  if (const std::string value = sheet_default(object); !value.empty()) {
    sheet.add("DefaultValue", value);
  }
  sheet.add("PDOMapping", object.mapping == PdoMapping::none ? "0" : "1");
}

/// Hex digits without a prefix, as in an EDS's section names.
std::string section_hex(std::uint64_t number, std::size_t digits) {
  constexpr std::size_t kPrefix = 2;  // "0x"
  return hex(number, digits).substr(kPrefix);
}

void add_index_sections(IndexObjects objects, SheetText& sheet) {
  constexpr std::size_t kIndexDigits = 4;
  const std::string section = section_hex(index_of_objects(objects), kIndexDigits);
  sheet.begin_section(section);
  if (objects.front().code == ObjectCode::variable) {
    add_object_keys(objects.front(), sheet);
    return;
  }
  // At least one reader refuses further keys for an array or a record.
  sheet.add("ParameterName", objects.front().index_name);
  sheet.add("ObjectType", object_code_text(objects.front().code));
  sheet.add("SubNumber", std::to_string(objects.size()));
  for (const NodeObject& object : objects) {
    sheet.begin_section(section + "sub" + section_hex(object.address.subindex, 1));
    add_object_keys(object, sheet);
  }
}

bool is_mandatory_index(std::uint16_t index) {
  return index == 0x1000 || index == 0x1001 || index == 0x1018;
}

bool is_manufacturer_index(std::uint16_t index) {
  return index >= 0x2000 && index < 0x6000;
}

bool is_optional_index(std::uint16_t index) {
  return !is_mandatory_index(index) && !is_manufacturer_index(index);
}

/// A CiA 306 list of indices, with the test for membership.
struct ObjectList {
  std::string_view section;
  bool (*has)(std::uint16_t index) = nullptr;
};

constexpr std::array kObjectLists{
    ObjectList{"MandatoryObjects", is_mandatory_index},
    ObjectList{"OptionalObjects", is_optional_index},
    ObjectList{"ManufacturerObjects", is_manufacturer_index},
};

/// Adds the list, then its objects.
void add_object_list(const ObjectList& list, const std::vector<IndexObjects>& indices,
                     SheetText& sheet) {
  constexpr std::size_t kIndexDigits = 4;
  std::vector<IndexObjects> listed;
  for (const IndexObjects objects : indices) {
    if (list.has(index_of_objects(objects))) listed.push_back(objects);
  }
  sheet.begin_section(list.section);
  sheet.add("SupportedObjects", std::to_string(listed.size()));
  for (std::size_t i = 0; i < listed.size(); ++i) {
    sheet.add(std::to_string(i + 1), hex(index_of_objects(listed[i]), kIndexDigits));
  }
  for (const IndexObjects objects : listed) add_index_sections(objects, sheet);
}

void add_file_info(const DataSheetSettings& settings, SheetText& sheet) {
  constexpr std::string_view kProgram = "vdrive";
  const std::size_t point = kDictionaryVersion.find('.');
  sheet.begin_section("FileInfo");
  sheet.add("FileName", settings.file_name);
  sheet.add("FileVersion", kDictionaryVersion.substr(0, point));
  sheet.add("FileRevision", kDictionaryVersion.substr(point + 1));
  sheet.add("EDSVersion", "4.0");
  sheet.add("Description",
            "Simulated servo drive of vdrive " + std::string(settings.program_version));
  sheet.add("CreationTime", settings.time);
  sheet.add("CreationDate", settings.date);
  sheet.add("CreatedBy", kProgram);
  sheet.add("ModificationTime", settings.time);
  sheet.add("ModificationDate", settings.date);
  sheet.add("ModifiedBy", kProgram);
}

/// @return a number of the identity object (1018h), written as in that object's section.
std::string identity_number(const std::vector<NodeObject>& objects, ObjectRow row) {
  const auto object = std::ranges::find(objects, describe(row).address, &NodeObject::address);
  ensure(object != objects.end(), "a row of the core's table is an object of the node");
  return sheet_number(*object, object->default_value);
}

/// @return the number of PDOs whose communication parameter is in the 512 indices from `first` on.
std::string count_pdos(const std::vector<IndexObjects>& indices, std::uint16_t first) {
  constexpr int kMostPdos = 512;
  return std::to_string(std::ranges::count_if(indices, [first](IndexObjects objects) {
    const int place = index_of_objects(objects) - first;
    return place >= 0 && place < kMostPdos;
  }));
}

void add_device_info(const std::vector<NodeObject>& objects,
                     const std::vector<IndexObjects>& indices, SheetText& sheet) {
  constexpr std::array<std::string_view, 8> kRates{"10",  "20",  "50",  "125",
                                                   "250", "500", "800", "1000"};
  sheet.begin_section("DeviceInfo");
  sheet.add("VendorName", "vdrive");
  sheet.add("VendorNumber", identity_number(objects, "vendor_id"_object));
  sheet.add("ProductName", "vdrive");
  sheet.add("ProductNumber", identity_number(objects, "product_code"_object));
  sheet.add("RevisionNumber", identity_number(objects, "revision_number"_object));
  sheet.add("OrderCode", "vdrive");
  for (const std::string_view rate : kRates) sheet.add("BaudRate_" + std::string(rate), "1");
  sheet.add("SimpleBootUpMaster", "0");
  sheet.add("SimpleBootUpSlave", "1");
  sheet.add("Granularity", "8");
  sheet.add("DynamicChannelsSupported", "0");
  sheet.add("CompactPDO", "0");
  sheet.add("GroupMessaging", "0");
  sheet.add("NrOfRXPDO", count_pdos(indices, 0x1400));
  sheet.add("NrOfTXPDO", count_pdos(indices, 0x1800));
  sheet.add("LSS_Supported", "0");
}

/// The types that an RPDO may map to skip bytes: all numbers except BOOLEAN, which is not a full
/// byte.
void add_dummy_usage(SheetText& sheet) {
  sheet.begin_section("DummyUsage");
  sheet.add("Dummy0001", "0");
  for (auto type = static_cast<unsigned>(NodeDataType::integer8);
       type <= static_cast<unsigned>(NodeDataType::unsigned32); ++type) {
    sheet.add("Dummy000" + std::to_string(type), "1");
  }
}

void add_comments(const DataSheetSettings& settings, SheetText& sheet) {
  sheet.begin_section("Comments");
  sheet.add("Lines", "2");
  sheet.add("Line1", "Positions are in user units of the axis, 4096 a revolution by default.");
  sheet.add("Line2", settings.values.empty()
                         ? "The configuration of the bench may set other default values."
                         : "Default values are those of this axis after its power-up.");
}

/// The section that makes a sheet a device configuration file; the misspelling is that of CiA 306.
void add_commissioning(std::uint8_t node_id, SheetText& sheet) {
  const std::string number = std::to_string(node_id);
  sheet.begin_section("DeviceComissioning");
  sheet.add("NodeID", number);
  sheet.add("NodeName", "vdrive " + number);
  sheet.add("Baudrate", "1000");
  sheet.add("NetNumber", "1");
  sheet.add("NetworkName", "");
  sheet.add("CANopenManager", "0");
  sheet.add("LSS_SerialNumber", "0");
}

/// @return node_objects() with the defaults replaced from the settings.
std::vector<NodeObject> objects_of(const DataSheetSettings& settings) {
  std::vector<NodeObject> objects(node_objects().begin(), node_objects().end());
  for (const DriveValue& value : settings.values) {
    const auto object = std::ranges::find(objects, value.object, &NodeObject::address);
    ensure(object != objects.end(), "a value has an object of the node");
    object->default_value = value.value;
  }
  if (!settings.node_id) return objects;
  for (NodeObject& object : objects) {
    object.default_value = default_of(object, *settings.node_id);
    object.has_node_id = false;
    if (object.address == kVersionObject) object.default_text = settings.program_version;
  }
  return objects;
}

}  // namespace

std::string electronic_data_sheet(const DataSheetSettings& settings) {
  const std::vector<NodeObject> objects = objects_of(settings);
  const std::vector<IndexObjects> indices = by_index(IndexObjects(objects));
  SheetText sheet;
  add_file_info(settings, sheet);
  add_device_info(objects, indices, sheet);
  add_dummy_usage(sheet);
  add_comments(settings, sheet);
  if (settings.node_id) add_commissioning(*settings.node_id, sheet);
  for (const ObjectList& list : kObjectLists) add_object_list(list, indices, sheet);
  return sheet.take();
}

std::string_view type_text(NodeDataType type) noexcept {
  switch (type) {
    case NodeDataType::integer8:
      return "INTEGER8";
    case NodeDataType::integer16:
      return "INTEGER16";
    case NodeDataType::integer32:
      return "INTEGER32";
    case NodeDataType::unsigned8:
      return "UNSIGNED8";
    case NodeDataType::unsigned16:
      return "UNSIGNED16";
    case NodeDataType::unsigned32:
      return "UNSIGNED32";
    case NodeDataType::visible_string:
      return "VISIBLE_STRING";
  }
  return "";
}

std::string_view access_text(const NodeObject& object) noexcept {
  switch (object.access) {
    case NodeAccess::read_only:
      return "ro";
    case NodeAccess::write_only:
      return "wo";
    case NodeAccess::constant:
      return "const";
    case NodeAccess::read_write:
      return "rw";
  }
  return "";
}

}  // namespace vdrive::canopen
