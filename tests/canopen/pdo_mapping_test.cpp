// SPDX-License-Identifier: Apache-2.0
#include "node/pdo_mapping.hpp"

#include "canopen/pdo_support.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr bool kInvalidPdo = false;  // its mapping may be written
constexpr bool kValidPdo = true;

/// An empty RPDO mapping.
MappingRecord empty_receive_mapping() {
  MappingRecord mapping(0x1600, PdoDirection::receive);
  EXPECT_EQ(mapping.write(0, 0, kInvalidPdo), AbortCode::none);
  return mapping;
}

/// An empty TPDO mapping.
MappingRecord empty_transmit_mapping() {
  MappingRecord mapping(0x1A00, PdoDirection::transmit);
  EXPECT_EQ(mapping.write(0, 0, kInvalidPdo), AbortCode::none);
  return mapping;
}

TEST(PdoMappingRecord, HasTheDefaultOfTheDictionary) {
  const MappingRecord mapping(0x1602, PdoDirection::receive);  // 6040h and 607Ah: 2 + 4 bytes
  EXPECT_EQ(mapping.read(0), 2U);
  EXPECT_EQ(mapping.read(1), kMapControlword);
  EXPECT_EQ(mapping.read(2), kMapTargetPosition);
  EXPECT_EQ(mapping.read(3), 0U);
  EXPECT_EQ(mapping.size(), 6U);
  ASSERT_EQ(mapping.objects().size(), 2U);
  EXPECT_EQ(mapping.objects()[1].address.index, 0x607AU);
}

TEST(PdoMappingRecord, KnowsWhereTheStatusHasAnObject) {
  const MappingRecord mapping(0x1A00, PdoDirection::transmit);
  ASSERT_EQ(mapping.objects().size(), 1U);
  ASSERT_NE(mapping.objects()[0].member, nullptr);
  EXPECT_EQ(mapping.objects()[0].member->name, "ds402_statusword");
}

TEST(PdoMappingRecord, RefusesAnEntryOfAValidPdoWith06010000) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, kMapMode, kValidPdo), AbortCode::unsupported_access);
  EXPECT_EQ(mapping.read(1), kMapControlword);
}

TEST(PdoMappingRecord, RefusesTheCountOfAValidPdoWith06010000) {
  MappingRecord mapping(0x1602, PdoDirection::receive);
  EXPECT_EQ(mapping.write(0, 0, kValidPdo), AbortCode::unsupported_access);
  EXPECT_EQ(mapping.write(0, 1, kValidPdo), AbortCode::unsupported_access);
  EXPECT_EQ(mapping.read(0), 2U);
}

TEST(PdoMappingRecord, RefusesAnEntryWhileItsCountIsNotZeroWith06010000) {
  MappingRecord mapping(0x1602, PdoDirection::receive);
  EXPECT_EQ(mapping.write(3, kMapMode, kInvalidPdo), AbortCode::unsupported_access);
  EXPECT_EQ(mapping.read(3), 0U);
}

TEST(PdoMappingRecord, TakesEntriesWhenItsCountIsZero) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.size(), 0U);
  EXPECT_EQ(mapping.write(1, kMapTargetPosition, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(2, kMapControlword, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(3, kMapMode, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.size(), 0U);  // the count activates the entries
  EXPECT_EQ(mapping.write(0, 3, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.size(), 7U);  // 4 + 2 + 1
}

TEST(PdoMappingRecord, RefusesAnObjectThatDoesNotExistWith06020000) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, map_entry(0x2000, 0, 32), kInvalidPdo),
            AbortCode::object_does_not_exist);
  EXPECT_EQ(mapping.write(1, 0xFFFFFFFF, kInvalidPdo), AbortCode::object_does_not_exist);
  EXPECT_EQ(mapping.read(1), kMapControlword);
}

TEST(PdoMappingRecord, RefusesASubindexThatDoesNotExistWith06020000) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, map_entry(0x6040, 1, 16), kInvalidPdo),
            AbortCode::object_does_not_exist);
  EXPECT_EQ(mapping.write(1, map_entry(0x607D, 9, 32), kInvalidPdo),
            AbortCode::object_does_not_exist);
}

TEST(PdoMappingRecord, RefusesWhatNoPdoCarriesWith06040041) {
  MappingRecord receive = empty_receive_mapping();
  EXPECT_EQ(receive.write(1, map_entry(0x1003, 0, 8), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
  EXPECT_EQ(receive.write(1, map_entry(0x1010, 1, 32), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
  EXPECT_EQ(receive.write(1, map_entry(0x1400, 1, 32), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
  MappingRecord transmit = empty_transmit_mapping();
  EXPECT_EQ(transmit.write(1, map_entry(0x1000, 0, 32), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
  EXPECT_EQ(transmit.write(1, map_entry(0x1A00, 0, 8), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
}

TEST(PdoMappingRecord, RefusesAnObjectOfTheOtherDirectionWith06040041) {
  MappingRecord receive = empty_receive_mapping();
  EXPECT_EQ(receive.write(1, kMapStatusword, kInvalidPdo), AbortCode::cannot_be_mapped_to_pdo);
  EXPECT_EQ(receive.write(1, kMapPosition, kInvalidPdo), AbortCode::cannot_be_mapped_to_pdo);
}

// CiA 301, 7.5.2.38: an object that can be read and written can be mapped in both directions.
TEST(PdoMappingRecord, TakesCommandsAndParametersInATpdo) {
  MappingRecord mapping = empty_transmit_mapping();
  EXPECT_EQ(mapping.write(1, kMapControlword, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(2, kMapTargetPosition, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(3, kMapStatusword, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(0, 3, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.size(), 8U);  // 2 + 4 + 2
  EXPECT_EQ(mapping.objects()[0].member, nullptr) << "it is read";
  EXPECT_EQ(mapping.objects()[1].member, nullptr);
  EXPECT_NE(mapping.objects()[2].member, nullptr) << "the status has it";
}

TEST(PdoMappingRecord, TakesReadOnlyObjectsThatTheStatusDoesNotHaveInATpdo) {
  MappingRecord mapping = empty_transmit_mapping();
  EXPECT_EQ(mapping.write(1, map_entry(0x6079, 0, 32), kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(2, map_entry(0x6502, 0, 32), kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(3, map_entry(0x1003, 0, 8), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
  EXPECT_EQ(mapping.write(3, map_entry(0x1010, 1, 32), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
}

TEST(PdoMappingRecord, RefusesAnotherLengthThanThatOfTheTypeWith06040041) {
  MappingRecord mapping = empty_receive_mapping();
  for (const std::uint32_t bits : {0U, 1U, 8U, 15U, 17U, 32U, 255U}) {
    EXPECT_EQ(mapping.write(1, map_entry(0x6040, 0, bits), kInvalidPdo),
              AbortCode::cannot_be_mapped_to_pdo)
        << bits << " bits of 16";
  }
  EXPECT_EQ(mapping.write(1, map_entry(0x6040, 0, 16), kInvalidPdo), AbortCode::none);
}

TEST(PdoMappingRecord, TakesEachDummyOfAnRpdoWithTheLengthOfItsType) {
  MappingRecord mapping = empty_receive_mapping();
  std::uint8_t subindex = 0;
  // INTEGER8, 16, 32, UNSIGNED8, 16, 32 (CiA 301, table of data types)
  for (const auto& [type, bits] : {std::pair{0x0002U, 8U}, std::pair{0x0003U, 16U},
                                   std::pair{0x0005U, 8U}, std::pair{0x0007U, 32U}}) {
    ++subindex;
    EXPECT_EQ(mapping.write(subindex, map_entry(type, 0, bits), kInvalidPdo), AbortCode::none)
        << type;
  }
  EXPECT_EQ(mapping.write(5, map_entry(0x0004, 0, 32), kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(6, map_entry(0x0006, 0, 16), kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(0, 4, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.size(), 8U);  // 1 + 2 + 1 + 4
  EXPECT_TRUE(mapping.objects()[0].is_dummy());
}

TEST(PdoMappingRecord, RefusesADummyOfAnotherLengthWith06040041) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, map_entry(0x0005, 0, 16), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
  EXPECT_EQ(mapping.write(1, map_entry(0x0007, 0, 0), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
}

TEST(PdoMappingRecord, RefusesADummyThatDoesNotExistWith06020000) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, map_entry(0x0001, 0, 1), kInvalidPdo),
            AbortCode::object_does_not_exist);
  EXPECT_EQ(mapping.write(1, map_entry(0x0008, 0, 32), kInvalidPdo),
            AbortCode::object_does_not_exist);
  EXPECT_EQ(mapping.write(1, map_entry(0x0005, 1, 8), kInvalidPdo),
            AbortCode::object_does_not_exist);
}

TEST(PdoMappingRecord, RefusesADummyInATpdoWith06040041) {
  MappingRecord mapping = empty_transmit_mapping();
  EXPECT_EQ(mapping.write(1, map_entry(0x0005, 0, 8), kInvalidPdo),
            AbortCode::cannot_be_mapped_to_pdo);
}

TEST(PdoMappingRecord, TakesEightBytes) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, kMapTargetPosition, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(2, kMapTargetVelocity, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(0, 2, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.size(), 8U);
}

TEST(PdoMappingRecord, TakesEightEntriesOfOneByte) {
  MappingRecord mapping = empty_receive_mapping();
  for (std::uint8_t subindex = 1; subindex <= 8; ++subindex) {
    EXPECT_EQ(mapping.write(subindex, kMapMode, kInvalidPdo), AbortCode::none);
  }
  EXPECT_EQ(mapping.write(0, 8, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.size(), 8U);
}

TEST(PdoMappingRecord, RefusesMoreThanEightBytesWith06040042) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, kMapTargetPosition, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(2, kMapTargetVelocity, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(3, kMapMode, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.write(0, 3, kInvalidPdo), AbortCode::pdo_length_exceeded);  // 4 + 4 + 1 bytes
  EXPECT_EQ(mapping.read(0), 0U);
  EXPECT_EQ(mapping.size(), 0U);
}

TEST(PdoMappingRecord, RefusesMoreEntriesThanAFrameHasBytesWith06040042) {
  MappingRecord mapping(0x1602, PdoDirection::receive);
  EXPECT_EQ(mapping.write(0, 9, kInvalidPdo), AbortCode::pdo_length_exceeded);
  EXPECT_EQ(mapping.write(0, 64, kInvalidPdo), AbortCode::pdo_length_exceeded);
  EXPECT_EQ(mapping.read(0), 2U);
}

TEST(PdoMappingRecord, RefusesMultiplexPdosAndReservedCountsWith06090030) {
  MappingRecord mapping(0x1602, PdoDirection::receive);
  for (const std::uint32_t count : {65U, 0xFDU, 0xFEU, 0xFFU}) {
    EXPECT_EQ(mapping.write(0, count, kInvalidPdo), AbortCode::value_range_exceeded) << count;
  }
}

TEST(PdoMappingRecord, RefusesACountOverAnEntryThatIsNotUsedWith06020000) {
  MappingRecord mapping(0x1602, PdoDirection::receive);
  EXPECT_EQ(mapping.write(0, 3, kInvalidPdo), AbortCode::object_does_not_exist);
  EXPECT_EQ(mapping.read(0), 2U);
}

TEST(PdoMappingRecord, TakesZeroForAnEntryThatIsNotUsed) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, 0, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.read(1), 0U);
}

TEST(PdoMappingRecord, KeepsTheEntriesBeyondItsCount) {
  MappingRecord mapping(0x1602, PdoDirection::receive);
  EXPECT_EQ(mapping.write(0, 1, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.read(2), kMapTargetPosition);
  EXPECT_EQ(mapping.size(), 2U);
  EXPECT_EQ(mapping.write(0, 2, kInvalidPdo), AbortCode::none);
  EXPECT_EQ(mapping.size(), 6U);
}

TEST(PdoMappingRecord, HasNoNinthEntry) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(9, kMapMode, kInvalidPdo), AbortCode::subindex_does_not_exist);
  EXPECT_EQ(mapping.read(9), 0U);
}

TEST(PdoMappingRecord, HasItsDefaultAgainAfterAReset) {
  MappingRecord mapping = empty_receive_mapping();
  EXPECT_EQ(mapping.write(1, kMapMode, kInvalidPdo), AbortCode::none);
  mapping.reset();
  EXPECT_EQ(mapping.read(0), 1U);
  EXPECT_EQ(mapping.read(1), kMapControlword);
  EXPECT_EQ(mapping.size(), 2U);
}

}  // namespace
}  // namespace vdrive::canopen
