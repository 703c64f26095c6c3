// SPDX-License-Identifier: Apache-2.0
// Reads the electronic data sheet with a strict parser: demands the rules of CiA 306, and refuses
// anything that lely-core's dcf tools, python-canopen or the npm package canopen refuse.
#include "node/electronic_data_sheet.hpp"

#include "node/node_object.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::MatchesRegex;

/// A section of an INI file with its entries in order.
struct SheetSection {
  std::string name;
  std::vector<std::pair<std::string, std::string>> entries;

  [[nodiscard]] std::optional<std::string> find(std::string_view key) const {
    for (const auto& [name_of_entry, value] : entries) {
      if (name_of_entry == key) return value;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::string at(std::string_view key) const {
    const std::optional<std::string> value = find(key);
    if (!value) throw std::runtime_error("[" + name + "] has no " + std::string(key));
    return *value;
  }

  [[nodiscard]] std::vector<std::string> keys() const {
    std::vector<std::string> names;
    for (const auto& entry : entries) names.push_back(entry.first);
    return names;
  }
};

using Sheet = std::vector<SheetSection>;

std::string in_small_letters(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return text;
}

/// @throws std::runtime_error for a line that is neither a section, an entry nor empty; for an
///         entry outside a section; for a repeated section or key, where case is ignored because
///         some readers ignore it.
Sheet parse_sheet(const std::string& text) {
  Sheet sheet;
  std::set<std::string> sections;
  std::set<std::string> keys;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    if (line.front() == '[') {
      if (line.back() != ']') throw std::runtime_error("no end of a section: " + line);
      sheet.push_back({line.substr(1, line.size() - 2), {}});
      keys.clear();
      if (!sections.insert(in_small_letters(line)).second)
        throw std::runtime_error("twice: " + line);
      continue;
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos || equals == 0 || sheet.empty()) {
      throw std::runtime_error("no entry of a section: " + line);
    }
    const std::string key = line.substr(0, equals);
    if (!keys.insert(in_small_letters(key)).second) throw std::runtime_error("twice: " + line);
    sheet.back().entries.emplace_back(key, line.substr(equals + 1));
  }
  return sheet;
}

/// A number in the notation of CiA 306: decimal, or 0x and capital hex digits.
std::int64_t sheet_value(const std::string& text) {
  const bool is_hex = text.starts_with("0x");
  const auto number = is_hex ? parse_digits<std::int64_t>(std::string_view(text).substr(2), 16)
                             : parse_digits<std::int64_t>(text);
  if (!number) throw std::runtime_error("no number: '" + text + "'");
  if (is_hex && hex(static_cast<std::uint64_t>(*number), text.size() - 2) != text) {
    throw std::runtime_error("hex without capitals: " + text);
  }
  return *number;
}

constexpr std::string_view kNodeIdText = "$NODEID+";

class ElectronicDataSheet : public testing::Test {
 protected:
  [[nodiscard]] const SheetSection& section(const std::string& name) const {
    const auto found = std::ranges::find(sheet_, name, &SheetSection::name);
    if (found == sheet_.end()) throw std::runtime_error("no section [" + name + "]");
    return *found;
  }

  [[nodiscard]] bool has_section(const std::string& name) const {
    return std::ranges::find(sheet_, name, &SheetSection::name) != sheet_.end();
  }

  /// The sections that describe values: variables, and the objects of arrays and records.
  [[nodiscard]] std::vector<SheetSection> values() const {
    std::vector<SheetSection> found;
    for (const SheetSection& candidate : sheet_) {
      if (candidate.find("DataType")) found.push_back(candidate);
    }
    return found;
  }

  [[nodiscard]] const SheetSection& section_of(ObjectAddress address) const {
    const NodeObject* const object = find_node_object(address);
    if (object == nullptr) throw std::runtime_error("no object " + address_text(address));
    const std::string index = hex(address.index, 4).substr(2);
    return section(object->code == ObjectCode::variable
                       ? index
                       : index + "sub" + hex(address.subindex, 1).substr(2));
  }

  explicit ElectronicDataSheet(const DataSheetSettings& settings = {})
      : text_(electronic_data_sheet(settings)) {}

  const std::string text_;
  const Sheet sheet_ = parse_sheet(text_);
};

TEST_F(ElectronicDataSheet, IsAsciiWithoutMarksOfComments) {
  EXPECT_TRUE(std::ranges::all_of(text_, [](char c) {
    return c == '\n' || (c >= ' ' && c <= '~' && c != ';' && c != '#');
  }));
  EXPECT_TRUE(text_.ends_with("\n"));
}

TEST_F(ElectronicDataSheet, HasItsSectionsInTheOrderOfTheStandard) {
  std::vector<std::string> names;
  for (const SheetSection& one : sheet_) {
    if (one.name.find_first_not_of("0123456789ABCDEFsub") != std::string::npos) {
      names.push_back(one.name);
    }
  }
  EXPECT_THAT(names, ElementsAre("FileInfo", "DeviceInfo", "DummyUsage", "Comments",
                                 "MandatoryObjects", "OptionalObjects", "ManufacturerObjects"));
}

TEST_F(ElectronicDataSheet, DescribesItsFile) {
  const SheetSection& info = section("FileInfo");
  EXPECT_THAT(info.keys(), ElementsAre("FileName", "FileVersion", "FileRevision", "EDSVersion",
                                       "Description", "CreationTime", "CreationDate", "CreatedBy",
                                       "ModificationTime", "ModificationDate", "ModifiedBy"));
  EXPECT_EQ(info.at("EDSVersion"), "4.0");
  EXPECT_EQ(info.at("FileVersion") + "." + info.at("FileRevision"), kDictionaryVersion);
  for (const char* const what : {"Creation", "Modification"}) {
    EXPECT_THAT(info.at(std::string(what) + "Date"),
                MatchesRegex("[01][0-9]-[0-3][0-9]-20[0-9]{2}"));
    EXPECT_THAT(info.at(std::string(what) + "Time"), MatchesRegex("[01][0-9]:[0-5][0-9](AM|PM)"));
  }
}

TEST_F(ElectronicDataSheet, DescribesTheDevice) {
  const SheetSection& info = section("DeviceInfo");
  EXPECT_THAT(info.keys(), ElementsAre("VendorName", "VendorNumber", "ProductName", "ProductNumber",
                                       "RevisionNumber", "OrderCode", "BaudRate_10", "BaudRate_20",
                                       "BaudRate_50", "BaudRate_125", "BaudRate_250",
                                       "BaudRate_500", "BaudRate_800", "BaudRate_1000",
                                       "SimpleBootUpMaster", "SimpleBootUpSlave", "Granularity",
                                       "DynamicChannelsSupported", "CompactPDO", "GroupMessaging",
                                       "NrOfRXPDO", "NrOfTXPDO", "LSS_Supported"));
  EXPECT_EQ(info.at("NrOfRXPDO"), "4");
  EXPECT_EQ(info.at("NrOfTXPDO"), "4");
  EXPECT_EQ(info.at("Granularity"), "8") << "PDOs map whole bytes";
}

TEST_F(ElectronicDataSheet, HasTheNumbersOfTheIdentityObjectInTheDeviceInfo) {
  const SheetSection& info = section("DeviceInfo");
  EXPECT_EQ(info.at("VendorNumber"), section("1018sub1").at("DefaultValue"));
  EXPECT_EQ(info.at("ProductNumber"), section("1018sub2").at("DefaultValue"));
  EXPECT_EQ(info.at("RevisionNumber"), section("1018sub3").at("DefaultValue"));
}

// A BOOLEAN does not fill a byte; INTEGER8 to UNSIGNED32 can be dummies in an RPDO.
TEST_F(ElectronicDataSheet, NamesAllDummies) {
  const SheetSection& dummies = section("DummyUsage");
  EXPECT_THAT(dummies.keys(), ElementsAre("Dummy0001", "Dummy0002", "Dummy0003", "Dummy0004",
                                          "Dummy0005", "Dummy0006", "Dummy0007"));
  for (const auto& [key, value] : dummies.entries) {
    EXPECT_EQ(value, key == "Dummy0001" ? "0" : "1") << key;
  }
}

TEST_F(ElectronicDataSheet, NumbersItsComments) {
  const SheetSection& comments = section("Comments");
  ASSERT_FALSE(comments.entries.empty());
  EXPECT_EQ(comments.entries.front().first, "Lines");
  EXPECT_EQ(comments.at("Lines"), std::to_string(comments.entries.size() - 1));
  for (std::size_t i = 1; i < comments.entries.size(); ++i) {
    EXPECT_EQ(comments.entries[i].first, "Line" + std::to_string(i));
  }
}

struct ListedIndex {
  std::string list;
  std::string index;  ///< the name of its section
};

/// All entries of the three lists, in order.
std::vector<ListedIndex> listed_indices(const Sheet& sheet) {
  std::vector<ListedIndex> listed;
  for (const SheetSection& list : sheet) {
    if (!list.name.ends_with("Objects")) continue;
    for (std::size_t i = 0; i < list.entries.size(); ++i) {
      const auto& [key, value] = list.entries[i];
      const bool is_head = i == 0;
      EXPECT_EQ(key, is_head ? "SupportedObjects" : std::to_string(i)) << list.name;
      EXPECT_EQ(is_head, !value.starts_with("0x")) << list.name;
      if (is_head) {
        EXPECT_EQ(value, std::to_string(list.entries.size() - 1)) << list.name;
      } else {
        EXPECT_THAT(value, MatchesRegex("0x[0-9A-F]{4}")) << list.name;
        listed.push_back({list.name, value.substr(2)});
      }
    }
  }
  return listed;
}

TEST_F(ElectronicDataSheet, ListsEachIndexOnceWithItsSection) {
  const std::vector<ListedIndex> listed = listed_indices(sheet_);
  std::set<std::string> indices;
  for (const ListedIndex& one : listed) {
    EXPECT_TRUE(indices.insert(one.index).second) << one.index << " is listed twice";
    EXPECT_TRUE(has_section(one.index)) << one.index;
  }
  EXPECT_EQ(indices.size(), by_index(node_objects()).size());
  for (const SheetSection& one : sheet_) {
    const bool is_index = one.name.find_first_not_of("0123456789ABCDEF") == std::string::npos;
    EXPECT_TRUE(!is_index || indices.contains(one.name)) << one.name << " is not listed";
  }
}

TEST_F(ElectronicDataSheet, ListsAnIndexWhereTheStandardHasIt) {
  std::vector<std::string> mandatory;
  for (const auto& [list, index] : listed_indices(sheet_)) {
    const std::int64_t number = sheet_value("0x" + index);
    EXPECT_GE(number, 0x1000) << "data types are no objects";
    if (list == "MandatoryObjects") mandatory.push_back(index);
    EXPECT_EQ(list == "ManufacturerObjects", number >= 0x2000 && number < 0x6000) << index;
  }
  EXPECT_THAT(mandatory, ElementsAre("1000", "1001", "1018"));
}

TEST_F(ElectronicDataSheet, HasEachObjectAfterItsIndex) {
  for (std::size_t i = 0; i < sheet_.size(); ++i) {
    const std::string& name = sheet_[i].name;
    const std::size_t sub = name.find("sub");
    if (sub == std::string::npos) continue;
    EXPECT_THAT(name, MatchesRegex("[0-9A-F]{4}sub(0|[1-9A-F][0-9A-F]?)"));
    ASSERT_GT(i, 0U);
    EXPECT_EQ(sheet_[i - 1].name.substr(0, sub), name.substr(0, sub)) << name;
  }
}

// The npm reader refuses further keys in an array or a record; lely-core refuses SubNumber
// elsewhere.
TEST_F(ElectronicDataSheet, CountsTheObjectsOfArraysAndRecords) {
  for (const auto& [list, index] : listed_indices(sheet_)) {
    const SheetSection& parent = section(index);
    std::ptrdiff_t objects = 0;
    for (const SheetSection& one : sheet_) objects += one.name.starts_with(index + "sub") ? 1 : 0;
    if (parent.at("ObjectType") == "0x7") {
      EXPECT_EQ(objects, 0) << index;
      EXPECT_EQ(parent.find("SubNumber"), std::nullopt) << index;
      continue;
    }
    EXPECT_THAT(parent.at("ObjectType"), MatchesRegex("0x[89]")) << index;
    EXPECT_THAT(parent.keys(), ElementsAre("ParameterName", "ObjectType", "SubNumber")) << index;
    EXPECT_EQ(parent.at("SubNumber"), std::to_string(objects)) << index;
    EXPECT_EQ(section(index + "sub0").at("DataType"), "0x0005") << index;
    EXPECT_EQ(section(index + "sub0").at("ObjectType"), "0x7") << index;
  }
}

TEST_F(ElectronicDataSheet, HasTheKeysOfAValueAndNoOthers) {
  const std::set<std::string> optional{"LowLimit", "HighLimit", "DefaultValue"};
  ASSERT_EQ(values().size(), node_objects().size());
  for (const SheetSection& value : values()) {
    std::vector<std::string> keys = value.keys();
    std::erase_if(keys, [&optional](const std::string& key) {
      return optional.contains(key);
    });
    EXPECT_THAT(keys,
                ElementsAre("ParameterName", "ObjectType", "DataType", "AccessType", "PDOMapping"))
        << value.name;
    EXPECT_FALSE(value.at("ParameterName").empty()) << value.name;
    EXPECT_EQ(value.at("ObjectType"), "0x7") << value.name;
    EXPECT_THAT(value.at("DataType"), MatchesRegex("0x000[2-79]")) << value.name;
    EXPECT_THAT(value.at("AccessType"), MatchesRegex("ro|wo|rw|const")) << value.name;
    EXPECT_THAT(value.at("PDOMapping"), MatchesRegex("[01]")) << value.name;
    EXPECT_EQ(value.find("LowLimit").has_value(), value.find("HighLimit").has_value())
        << value.name;
  }
}

/// The range of each CiA 301 data type, by type number.
std::pair<std::int64_t, std::int64_t> type_limits(std::int64_t type) {
  static const std::map<std::int64_t, std::pair<std::int64_t, std::int64_t>> limits{
      {2, {-128, 127}}, {3, {-32'768, 32'767}}, {4, {-2'147'483'648, 2'147'483'647}},
      {5, {0, 255}},    {6, {0, 65'535}},       {7, {0, 4'294'967'295}}};
  return limits.at(type);
}

TEST_F(ElectronicDataSheet, HasDefaultsWithinTypeAndLimits) {
  constexpr std::int64_t kHighestNodeId = 127;
  for (const SheetSection& value : values()) {
    SCOPED_TRACE(value.name);
    if (value.at("DataType") == "0x0009") {
      EXPECT_EQ(value.find("LowLimit"), std::nullopt);
      EXPECT_EQ(value.find("HighLimit"), std::nullopt);
      continue;
    }
    auto [low, high] = type_limits(sheet_value(value.at("DataType")));
    if (const auto limit = value.find("LowLimit")) {
      EXPECT_GE(sheet_value(*limit), low);
      low = sheet_value(*limit);
    }
    if (const auto limit = value.find("HighLimit")) {
      EXPECT_LE(sheet_value(*limit), high);
      high = sheet_value(*limit);
    }
    const std::string text = value.at("DefaultValue");
    const bool has_node_id = text.starts_with(kNodeIdText);
    const std::int64_t number = sheet_value(has_node_id ? text.substr(kNodeIdText.size()) : text);
    EXPECT_GE(number, low);
    EXPECT_LE(number + (has_node_id ? kHighestNodeId : 0), high);
  }
}

TEST_F(ElectronicDataSheet, HasEveryObjectOfTheNodeAsTheNodeHasIt) {
  for (const NodeObject& object : node_objects()) {
    SCOPED_TRACE(address_text(object.address));
    const SheetSection& value = section_of(object.address);
    EXPECT_EQ(value.at("ParameterName"), object.name);
    EXPECT_EQ(sheet_value(value.at("DataType")), static_cast<std::int64_t>(object.data_type));
    EXPECT_EQ(value.at("PDOMapping"), object.mapping == PdoMapping::none ? "0" : "1");
    EXPECT_EQ(sheet_value(section(hex(object.address.index, 4).substr(2)).at("ObjectType")),
              static_cast<std::int64_t>(object.code));
    if (object.data_type == NodeDataType::visible_string) {
      EXPECT_EQ(value.find("DefaultValue").value_or(""), object.default_text);
      continue;
    }
    const std::string text = value.at("DefaultValue");
    EXPECT_EQ(text.starts_with(kNodeIdText), object.has_node_id);
    EXPECT_EQ(sheet_value(object.has_node_id ? text.substr(kNodeIdText.size()) : text),
              object.default_value);
    const auto [low, high] = type_limits(static_cast<std::int64_t>(object.data_type));
    EXPECT_EQ(sheet_value(value.find("LowLimit").value_or(std::to_string(low))),
              object.lower_limit);
    EXPECT_EQ(sheet_value(value.find("HighLimit").value_or(std::to_string(high))),
              object.upper_limit);
  }
}

TEST_F(ElectronicDataSheet, AddsTheNodeIdInFrontOfACobId) {
  EXPECT_EQ(section("1400sub1").at("DefaultValue"), "$NODEID+0x200");
  EXPECT_EQ(section("1803sub1").at("DefaultValue"), "$NODEID+0x480");
  EXPECT_EQ(section("1014").at("DefaultValue"), "$NODEID+0x80");
  EXPECT_EQ(section("1005").at("DefaultValue"), "0x00000080");
}

// Readers interpret negative hex numbers differently, so these are written in decimal.
TEST_F(ElectronicDataSheet, WritesNegativeNumbersInDecimal) {
  EXPECT_EQ(section("607Dsub1").at("DefaultValue"), "-2147483648");
  EXPECT_EQ(section("6098").at("LowLimit"), "-4");
  EXPECT_EQ(section("6098").at("HighLimit"), "37");
}

TEST_F(ElectronicDataSheet, HasTheAccessOfCiA306) {
  EXPECT_EQ(section("6040").at("AccessType"), "rw") << "mapped both ways";
  EXPECT_EQ(section("6040").at("PDOMapping"), "1");
  EXPECT_EQ(section("6079").at("PDOMapping"), "1");
  EXPECT_EQ(section("6502").at("PDOMapping"), "1");
  EXPECT_EQ(section("6041").at("AccessType"), "ro");
  EXPECT_EQ(section("1008").at("AccessType"), "const");
  EXPECT_EQ(section("1010sub1").at("AccessType"), "rw");
  EXPECT_EQ(section("1600sub0").at("AccessType"), "rw");
  for (const char* const once : {"60C4sub5", "60C4sub6"}) {
    EXPECT_EQ(section(once).at("AccessType"), "wo") << "CiA 402-2";
    EXPECT_EQ(section(once).at("PDOMapping"), "1");
  }
}

/// The DCF of node 3, whose drive deviates from the defaults of the dictionary.
class DeviceConfigurationFile : public ElectronicDataSheet {
 protected:
  static constexpr std::array<DriveValue, 3> kValues{{
      {.object = {0x1018, 2}, .value = 77},
      {.object = {0x6065, 0}, .value = 99},
      {.object = {0x607D, 1}, .value = -5},
  }};

  DeviceConfigurationFile()
      : ElectronicDataSheet({.program_version = "1.2.3", .node_id = 3, .values = kValues}) {}
};

// The npm package canopen does not know $NODEID and takes it for 0.
TEST_F(DeviceConfigurationFile, HasNumbersForCobIds) {
  EXPECT_EQ(text_.find('$'), std::string::npos);
  EXPECT_EQ(section("1400sub1").at("DefaultValue"), "0x00000203");
  EXPECT_EQ(section("1803sub1").at("DefaultValue"), "0x00000483");
  EXPECT_EQ(section("1014").at("DefaultValue"), "0x00000083");
  EXPECT_EQ(section("1200sub2").at("DefaultValue"), "0x00000583");
  EXPECT_EQ(section("1005").at("DefaultValue"), "0x00000080") << "of no node";
}

TEST_F(DeviceConfigurationFile, NamesItsNode) {
  const SheetSection& commissioning = section("DeviceComissioning");
  EXPECT_THAT(commissioning.keys(),
              ElementsAre("NodeID", "NodeName", "Baudrate", "NetNumber", "NetworkName",
                          "CANopenManager", "LSS_SerialNumber"));
  EXPECT_EQ(commissioning.at("NodeID"), "3");
}

TEST_F(DeviceConfigurationFile, HasTheValuesOfItsDrive) {
  EXPECT_EQ(section("6065").at("DefaultValue"), "99");
  EXPECT_EQ(section("607Dsub1").at("DefaultValue"), "-5");
  EXPECT_EQ(section("1018sub2").at("DefaultValue"), "0x0000004D");
  EXPECT_EQ(section("DeviceInfo").at("ProductNumber"), "0x0000004D");
  EXPECT_EQ(section("100A").at("DefaultValue"), "1.2.3");
  EXPECT_EQ(section("6066").at("DefaultValue"),
            std::to_string(find_node_object({0x6066, 0})->default_value));
}

// Entries of 1600h.. and 1A00h..: index, sub-index and length [bits] of the mapped object.
TEST_F(ElectronicDataSheet, HasEveryMappedObject) {
  std::size_t mapped = 0;
  for (const std::string first : {"160", "1A0"}) {
    for (const char pdo : {'0', '1', '2', '3'}) {
      const std::string index = first + pdo;
      const std::int64_t count = sheet_value(section(index + "sub0").at("DefaultValue"));
      ASSERT_GE(count, 1) << index;
      for (std::int64_t i = 1; i <= count; ++i) {
        const std::int64_t entry =
            sheet_value(section(index + "sub" + std::to_string(i)).at("DefaultValue"));
        const ObjectAddress address{static_cast<std::uint16_t>(entry / 0x10000),
                                    static_cast<std::uint8_t>(entry / 0x100 % 0x100)};
        const SheetSection& object = section_of(address);
        EXPECT_EQ(object.at("PDOMapping"), "1") << object.name;
        EXPECT_EQ(object.at("AccessType"), first == "160" ? "rw" : "ro") << object.name;
        EXPECT_EQ(entry % 0x100, size_of(find_node_object(address)->data_type) * 8) << object.name;
        ++mapped;
      }
    }
  }
  EXPECT_EQ(mapped, 14U) << "one in the first PDO of each kind, two in the others";
}

TEST(ElectronicDataSheetSettings, GiveEqualBytesForEqualSettings) {
  const DataSheetSettings settings{
      .file_name = "axis.eds", .program_version = "1.2.3", .date = "02-29-2028", .time = "11:59PM"};
  const std::string text = electronic_data_sheet(settings);
  EXPECT_EQ(text, electronic_data_sheet(settings));
  EXPECT_THAT(text, HasSubstr("\nFileName=axis.eds\n"));
  EXPECT_THAT(text, HasSubstr("\nDescription=Simulated servo drive of vdrive 1.2.3\n"));
  EXPECT_THAT(text, HasSubstr("\nCreationDate=02-29-2028\n"));
  EXPECT_THAT(text, HasSubstr("\nModificationTime=11:59PM\n"));
}

TEST(StrictParser, RefusesWhatReadersRefuse) {
  EXPECT_THROW(parse_sheet("[1000\n"), std::runtime_error);
  EXPECT_THROW(parse_sheet("Lines=0\n"), std::runtime_error);
  EXPECT_THROW(parse_sheet("[1000]\nObjectType\n"), std::runtime_error);
  EXPECT_THROW(parse_sheet("[607a]\n[607A]\n"), std::runtime_error);
  EXPECT_THROW(parse_sheet("[1000]\nDataType=1\ndatatype=1\n"), std::runtime_error);
  EXPECT_THROW(sheet_value("0x1a"), std::runtime_error);
  EXPECT_THROW(sheet_value("$NODEID+0x180"), std::runtime_error);
  EXPECT_EQ(sheet_value("0x001A"), 26);
  EXPECT_EQ(sheet_value("-5"), -5);
}

TEST(SheetWords, AreThoseOfTheStandards) {
  EXPECT_EQ(type_text(NodeDataType::unsigned16), "UNSIGNED16");
  EXPECT_EQ(type_text(NodeDataType::integer8), "INTEGER8");
  EXPECT_EQ(type_text(NodeDataType::visible_string), "VISIBLE_STRING");
  NodeObject object;
  object.access = NodeAccess::write_only;
  EXPECT_EQ(access_text(object), "wo");
}

}  // namespace
}  // namespace vdrive::canopen
