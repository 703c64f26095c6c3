// SPDX-License-Identifier: Apache-2.0
// The object dictionary of a CANopen node: the rows of the core, the communication objects, and the
// counts in sub-index 0.
#include "node/node_object.hpp"

#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::ElementsAre;
using Indices = std::initializer_list<std::uint16_t>;

constexpr int kPdosOfAKind = 4;

const NodeObject& dictionary_object(std::uint16_t index, std::uint8_t subindex = 0) {
  const NodeObject* const object = find_node_object({.index = index, .subindex = subindex});
  if (object == nullptr) throw std::out_of_range(address_text({index, subindex}));
  return *object;
}

std::uint16_t index_of_pdo(int first, int pdo) {
  return static_cast<std::uint16_t>(first + pdo);
}

std::int64_t default_at(std::uint16_t index, std::uint8_t subindex, std::uint8_t node_id = 0) {
  return default_of(dictionary_object(index, subindex), node_id);
}

std::vector<std::int64_t> default_mapping(std::uint16_t mapping) {
  std::vector<std::int64_t> entries;
  const std::int64_t count = default_at(mapping, 0);
  for (std::uint8_t i = 1; i <= 8; ++i) {
    const std::int64_t entry = default_at(mapping, i);
    if (i <= count) {
      entries.push_back(entry);
    } else {
      EXPECT_EQ(entry, 0) << "entries behind the count are empty";
    }
  }
  return entries;
}

TEST(NodeObjects, StandByIndexAndSubIndexEachOnce) {
  const auto objects = node_objects();
  ASSERT_GT(objects.size(), kObjectTable.size());
  for (std::size_t i = 1; i < objects.size(); ++i) {
    EXPECT_LT(objects[i - 1].address, objects[i].address) << address_text(objects[i].address);
  }
}

TEST(NodeObjects, HaveEveryRowOfTheCoreAsTheDriveHasIt) {
  for (const ObjectDescription& row : kObjectTable) {
    const NodeObject* const object = find_node_object(row.address);
    ASSERT_NE(object, nullptr) << address_text(row.address);
    EXPECT_EQ(object->owner, ObjectOwner::drive) << address_text(row.address);
    EXPECT_EQ(object->name, row.name);
    EXPECT_EQ(size_of(object->data_type), size_of(row.data_type)) << row.name;
    EXPECT_EQ(object->access == NodeAccess::read_only, row.access == Access::read_only) << row.name;
    EXPECT_EQ(object->lower_limit, row.lower_limit) << row.name;
    EXPECT_EQ(object->upper_limit, row.upper_limit) << row.name;
    EXPECT_EQ(object->default_value, row.default_value) << row.name;
    EXPECT_FALSE(object->has_node_id) << row.name;
  }
}

TEST(NodeObjects, AreTheNodesWhereTheCoreHasNone) {
  for (const NodeObject& object : node_objects()) {
    EXPECT_EQ(object.owner == ObjectOwner::drive, find_object(object.address).has_value())
        << address_text(object.address);
  }
}

// CiA 301: sub-index 0 of an array or a record holds the highest sub-index as UNSIGNED8.
TEST(NodeObjects, CountTheObjectsOfEachArrayAndRecord) {
  for (const auto objects : by_index(node_objects())) {
    const NodeObject& first = objects.front();
    SCOPED_TRACE(address_text(first.address));
    ASSERT_EQ(first.address.subindex, 0);
    EXPECT_EQ(first.code == ObjectCode::variable, objects.size() == 1);
    for (const NodeObject& object : objects) {
      EXPECT_EQ(object.code, first.code);
      EXPECT_EQ(object.index_name, first.index_name);
      EXPECT_FALSE(object.index_name.empty());
    }
    if (first.code == ObjectCode::variable) continue;
    EXPECT_EQ(first.data_type, NodeDataType::unsigned8);
    if (first.access == NodeAccess::constant) {
      EXPECT_EQ(first.default_value, objects.back().address.subindex);
    } else {
      EXPECT_EQ(first.upper_limit, objects.back().address.subindex);
    }
  }
}

TEST(NodeObjects, HaveTheCountsOfTheDrivesArraysWhichTheCoreLacks) {
  EXPECT_EQ(default_at(0x1010, 0), 1);
  EXPECT_EQ(default_at(0x1011, 0), 1);
  EXPECT_EQ(default_at(0x1018, 0), 4);
  EXPECT_EQ(default_at(0x5E10, 0), 5);
  EXPECT_EQ(default_at(0x607D, 0), 2);
  EXPECT_EQ(default_at(0x6099, 0), 2);
  EXPECT_EQ(dictionary_object(0x607D).owner, ObjectOwner::node);
  EXPECT_EQ(dictionary_object(0x1003).owner, ObjectOwner::drive) << "the drive counts its errors";
  EXPECT_EQ(dictionary_object(0x1003).access, NodeAccess::read_write) << "0 clears the history";
}

struct NodeObjectShapeRow {
  std::uint16_t index;
  ObjectCode code;
};

class NodeObjectShape : public testing::TestWithParam<NodeObjectShapeRow> {};

TEST_P(NodeObjectShape, IsThatOfTheStandard) {
  EXPECT_EQ(dictionary_object(GetParam().index).code, GetParam().code);
}

INSTANTIATE_TEST_SUITE_P(NodeObjects, NodeObjectShape,
                         testing::Values(NodeObjectShapeRow{0x1000, ObjectCode::variable},
                                         NodeObjectShapeRow{0x1003, ObjectCode::array},
                                         NodeObjectShapeRow{0x1010, ObjectCode::array},
                                         NodeObjectShapeRow{0x1011, ObjectCode::array},
                                         NodeObjectShapeRow{0x1016, ObjectCode::array},
                                         NodeObjectShapeRow{0x1018, ObjectCode::record},
                                         NodeObjectShapeRow{0x1029, ObjectCode::array},
                                         NodeObjectShapeRow{0x1200, ObjectCode::record},
                                         NodeObjectShapeRow{0x1400, ObjectCode::record},
                                         NodeObjectShapeRow{0x1603, ObjectCode::record},
                                         NodeObjectShapeRow{0x1801, ObjectCode::record},
                                         NodeObjectShapeRow{0x1A02, ObjectCode::record},
                                         NodeObjectShapeRow{0x6040, ObjectCode::variable},
                                         NodeObjectShapeRow{0x607D, ObjectCode::array},
                                         NodeObjectShapeRow{0x6099, ObjectCode::array}),
                         [](const auto& row) {
                           return address_text({row.param.index, 0});
                         });

TEST(NodeObjects, NameAnIndexByTheWordsThatItsObjectsShare) {
  EXPECT_EQ(dictionary_object(0x1003, 1).index_name, "Error Field");
  EXPECT_EQ(dictionary_object(0x1018, 1).index_name, "Identity Object");
  EXPECT_EQ(dictionary_object(0x5E10, 1).index_name, "Synchronous Move");
  EXPECT_EQ(dictionary_object(0x607D, 1).index_name, "User Position");
  EXPECT_EQ(dictionary_object(0x6099, 1).index_name, "Homing Speed");
  EXPECT_EQ(dictionary_object(0x1010, 1).index_name, "Store All Parameters");
}

TEST(NodeObjects, HaveNamesThatAnElectronicDataSheetCanHold) {
  for (const NodeObject& object : node_objects()) {
    for (const std::string_view name : {object.name, object.index_name}) {
      EXPECT_FALSE(name.empty()) << address_text(object.address);
      EXPECT_TRUE(std::ranges::all_of(name, [](char c) {
        return c >= ' ' && c <= '~' && c != ';' && c != '#';
      })) << name;
    }
  }
}

TEST(NodeObjects, HaveDefaultsWithinTheirLimits) {
  for (const NodeObject& object : node_objects()) {
    if (object.data_type == NodeDataType::visible_string) continue;
    EXPECT_LE(object.lower_limit, object.default_value) << address_text(object.address);
    EXPECT_GE(object.upper_limit, object.default_value) << address_text(object.address);
  }
}

TEST(NodeObjects, AreFoundByTheirAddressOnly) {
  EXPECT_EQ(find_node_object({0x6041, 0})->name, "DS402 Statusword");
  EXPECT_EQ(find_node_object({0x6041, 1}), nullptr);
  EXPECT_EQ(find_node_object({0x0000, 0}), nullptr);
  EXPECT_EQ(find_node_object({0xFFFF, 0xFF}), nullptr);
}

// Node guarding (100Ch, 100Dh) is absent, 1400h has no inhibit time, and dummies are not objects.
TEST(NodeObjects, AnswerAnUnknownIndexAndAnUnknownSubIndexDifferently) {
  EXPECT_EQ(check_node_address({0x1400, 1}), AbortCode::none);
  EXPECT_EQ(check_node_address({0x607D, 0}), AbortCode::none);
  for (const std::uint16_t index :
       Indices{0x0005, 0x100C, 0x100D, 0x1021, 0x1404, 0x1FFF, 0x2000, 0xFFFF}) {
    EXPECT_EQ(check_node_address({index, 0}), AbortCode::object_does_not_exist) << index;
  }
  EXPECT_EQ(check_node_address({0x1400, 3}), AbortCode::subindex_does_not_exist);
  EXPECT_EQ(check_node_address({0x1A00, 9}), AbortCode::subindex_does_not_exist);
  EXPECT_EQ(check_node_address({0x6041, 1}), AbortCode::subindex_does_not_exist);
}

TEST(NodeObjects, HaveTheSizeOfTheirType) {
  EXPECT_EQ(size_of(dictionary_object(0x6060).data_type), 1);
  EXPECT_EQ(size_of(dictionary_object(0x1017).data_type), 2);
  EXPECT_EQ(size_of(dictionary_object(0x1400, 1).data_type), 4);
  EXPECT_EQ(size_of(dictionary_object(0x1008).data_type), 0)
      << "a text has the length of its value";
}

TEST(NodeObjects, MapWhatTheStatusHasToTransmitPdos) {
  for (const ObjectDescription& row : kObjectTable) {
    const bool is_in_status = value_of(AxisStatus{}, *find_object(row.address)).has_value();
    if (is_in_status) {
      EXPECT_EQ(find_node_object(row.address)->mapping, PdoMapping::transmit) << row.name;
    }
  }
  EXPECT_EQ(dictionary_object(0x6041).mapping, PdoMapping::transmit);
  EXPECT_EQ(dictionary_object(0x6064).mapping, PdoMapping::transmit);
}

// CiA 402 lets 6079h and 6502h be mapped into TPDOs; CiA 301 does not let 1000h and 1018h be.
TEST(NodeObjects, MapEveryReadOnlyObjectOfTheProfileToTransmitPdos) {
  for (const std::uint16_t index : Indices{0x6079, 0x6402, 0x6502, 0x5E11}) {
    EXPECT_EQ(dictionary_object(index).mapping, PdoMapping::transmit) << address_text({index, 0});
  }
  EXPECT_EQ(dictionary_object(0x1000).mapping, PdoMapping::none);
  EXPECT_EQ(dictionary_object(0x1001).mapping, PdoMapping::transmit);
  EXPECT_EQ(dictionary_object(0x1018, 1).mapping, PdoMapping::none);
}

TEST(NodeObjects, MapWritableObjectsToPdosOfBothDirectionsButNotMemoryAndHistory) {
  for (const std::uint16_t index : Indices{0x6040, 0x6060, 0x6071, 0x607A, 0x6081, 0x60FF}) {
    EXPECT_EQ(dictionary_object(index).mapping, PdoMapping::both) << address_text({index, 0});
  }
  EXPECT_EQ(dictionary_object(0x1003).mapping, PdoMapping::none);
  EXPECT_EQ(dictionary_object(0x1010, 1).mapping, PdoMapping::none);
  EXPECT_EQ(dictionary_object(0x1011, 1).mapping, PdoMapping::none);
}

TEST(NodeObjects, AreWrittenOnlyWhereCiA402SaysSo) {
  for (const NodeObject& object : node_objects()) {
    const bool is_written_only =
        object.address == ObjectAddress{0x60C4, 5} || object.address == ObjectAddress{0x60C4, 6};
    EXPECT_EQ(object.access == NodeAccess::write_only, is_written_only)
        << address_text(object.address);
    if (!is_written_only) continue;
    EXPECT_TRUE(allows(object.mapping, PdoDirection::receive));
    EXPECT_FALSE(allows(object.mapping, PdoDirection::transmit)) << "nobody could read it";
  }
}

TEST(NodeObjects, MapNoObjectOfTheNodeItself) {
  for (const NodeObject& object : node_objects()) {
    if (object.owner == ObjectOwner::drive) continue;
    EXPECT_EQ(object.mapping, PdoMapping::none) << address_text(object.address);
  }
}

// The predefined connection set: RPDOs 200h, 300h, 400h, 500h; TPDOs 180h, 280h, 380h, 480h.
TEST(CommunicationObjects, HaveTheCobIdsOfThePredefinedConnectionSet) {
  constexpr std::uint8_t kNode = 5;
  for (int pdo = 0; pdo < kPdosOfAKind; ++pdo) {
    EXPECT_EQ(default_at(index_of_pdo(0x1400, pdo), 1, kNode), 0x205 + pdo * 0x100);
    EXPECT_EQ(default_at(index_of_pdo(0x1800, pdo), 1, kNode), 0x185 + pdo * 0x100);
  }
  EXPECT_EQ(default_at(0x1005, 0, kNode), 0x80) << "SYNC has the same identifier in every node";
  EXPECT_EQ(default_at(0x1014, 0, kNode), 0x85);
  EXPECT_EQ(default_at(0x1200, 1, kNode), 0x605);
  EXPECT_EQ(default_at(0x1200, 2, kNode), 0x585);
}

// Index, sub-index, bits: 6040h and 6041h have 16 bits, 6060h and 6061h 8, the others 32.
TEST(CommunicationObjects, MapTheDefaultsOfTheDeviceProfile) {
  EXPECT_THAT(default_mapping(0x1600), ElementsAre(0x60400010));
  EXPECT_THAT(default_mapping(0x1601), ElementsAre(0x60400010, 0x60600008));
  EXPECT_THAT(default_mapping(0x1602), ElementsAre(0x60400010, 0x607A0020));
  EXPECT_THAT(default_mapping(0x1603), ElementsAre(0x60400010, 0x60FF0020));
  EXPECT_THAT(default_mapping(0x1A00), ElementsAre(0x60410010));
  EXPECT_THAT(default_mapping(0x1A01), ElementsAre(0x60410010, 0x60610008));
  EXPECT_THAT(default_mapping(0x1A02), ElementsAre(0x60410010, 0x60640020));
  EXPECT_THAT(default_mapping(0x1A03), ElementsAre(0x60410010, 0x606C0020));
}

TEST(CommunicationObjects, MapByDefaultWhatTheirDirectionMayMap) {
  for (int pdo = 0; pdo < kPdosOfAKind; ++pdo) {
    for (const auto& [first, direction] :
         {std::pair(0x1600, PdoDirection::receive), std::pair(0x1A00, PdoDirection::transmit)}) {
      for (const std::int64_t entry : default_mapping(index_of_pdo(first, pdo))) {
        const NodeObject& object =
            dictionary_object(static_cast<std::uint16_t>(entry / 0x10000),
                              static_cast<std::uint8_t>(entry / 0x100 % 0x100));
        EXPECT_TRUE(allows(object.mapping, direction)) << object.name;
        EXPECT_EQ(size_of(object.data_type) * 8, entry % 0x100) << object.name;
      }
    }
  }
}

TEST(CommunicationObjects, SendEventDrivenAndLimitTheRateOfPositionsAndVelocities) {
  for (int pdo = 0; pdo < kPdosOfAKind; ++pdo) {
    EXPECT_EQ(default_at(index_of_pdo(0x1400, pdo), 2), 255);
    EXPECT_EQ(default_at(index_of_pdo(0x1800, pdo), 2), 255);
    EXPECT_EQ(default_at(index_of_pdo(0x1400, pdo), 5), 0) << "no deadline";
    EXPECT_EQ(default_at(index_of_pdo(0x1800, pdo), 5), 0) << "no event timer";
    EXPECT_EQ(default_at(index_of_pdo(0x1800, pdo), 6), 0) << "no SYNC start value";
  }
  EXPECT_EQ(default_at(0x1800, 3), 0);
  EXPECT_EQ(default_at(0x1801, 3), 0);
  EXPECT_EQ(default_at(0x1802, 3), 100) << "100 x 100 us = 10 ms";
  EXPECT_EQ(default_at(0x1803, 3), 100);
}

TEST(CommunicationObjects, BeginWithoutHeartbeatSyncPeriodAndInhibitTime) {
  for (const std::uint16_t index : Indices{0x1006, 0x1007, 0x1015, 0x1017, 0x1019}) {
    EXPECT_EQ(default_at(index, 0), 0) << address_text({index, 0});
  }
  EXPECT_EQ(default_at(0x1016, 0), 4);
  for (std::uint8_t i = 1; i <= 4; ++i) EXPECT_EQ(default_at(0x1016, i), 0);
  EXPECT_EQ(default_at(0x1029, 1), 0) << "pre-operational after a communication error";
}

// CiA 301: the maximum of 1019h and 1800h:06 is 240; 1029h:01 is 0, 1 or 2.
TEST(CommunicationObjects, HaveTheLimitsOfTheStandard) {
  EXPECT_EQ(dictionary_object(0x1019).upper_limit, 240);
  EXPECT_EQ(dictionary_object(0x1800, 6).upper_limit, 240);
  EXPECT_EQ(dictionary_object(0x1029, 1).upper_limit, 2);
  EXPECT_EQ(dictionary_object(0x1600).upper_limit, 8);
  EXPECT_EQ(dictionary_object(0x1017).upper_limit, 65'535);
}

TEST(CommunicationObjects, KeepCountsTextsAndTheSdoServerConstant) {
  for (const std::uint16_t index : Indices{0x1008, 0x1009, 0x100A, 0x1200, 0x1400, 0x1800}) {
    EXPECT_EQ(dictionary_object(index).access, NodeAccess::constant) << address_text({index, 0});
  }
  EXPECT_EQ(dictionary_object(0x1200, 1).access, NodeAccess::constant);
  EXPECT_EQ(dictionary_object(0x1600).access, NodeAccess::read_write)
      << "the count of a mapping is written";
  EXPECT_EQ(dictionary_object(0x1008).default_text, "vdrive");
}

}  // namespace
}  // namespace vdrive::canopen
