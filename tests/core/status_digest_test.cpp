// SPDX-License-Identifier: Apache-2.0
#include "vdrive/status_digest.hpp"

#include "support/random_cases.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <set>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using test::Random;

std::vector<AxisStatus> random_statuses(std::size_t count, Random& random) {
  std::vector<AxisStatus> statuses(count);
  for (AxisStatus& status : statuses) {
    std::array<std::uint32_t, sizeof(AxisStatus) / sizeof(std::uint32_t)> words{};
    for (std::uint32_t& word : words) word = random.word();
    status = std::bit_cast<AxisStatus>(words);
  }
  return statuses;
}

TEST(StatusDigest, NamesEveryMemberOfAxisStatusOnce) {
  std::set<std::string_view> names;
  for (const StatusMember& member : status_members()) {
    EXPECT_TRUE(names.insert(member.name).second) << member.name;
    // The only members that are not objects of the dictionary are the two counts.
    EXPECT_EQ(member.address.index == 0,
              member.name == "ignored_set_points" || member.name == "fault_count")
        << member.name;
  }
  EXPECT_EQ(status_members()[14].name, "ds402_statusword");
  EXPECT_EQ(status_members()[14].address, (ObjectAddress{0x6041, 0}));
}

/// 60FDh has 32 bits, of which the drive uses three, so its member is shorter.
TEST(StatusMembers, HaveTheTypesOfTheirObjects) {
  for (const StatusMember& member : status_members()) {
    const auto row = find_object(member.address);
    if (!row || member.name == "digital_inputs") continue;
    EXPECT_EQ(member.data_type, describe(*row).data_type) << member.name;
  }
  EXPECT_EQ(status_members()[kStatusMembers - 1].data_type, DataType::unsigned32) << "fault_count";
}

/// A member that the table lacks would keep its random value.
TEST(StatusMembers, SetTheWholeImage) {
  Random random(5);
  AxisStatus status = random_statuses(1, random).front();
  for (const StatusMember& member : status_members()) {
    member.set(status, 0);
    EXPECT_EQ(member.value(status), 0) << member.name;
  }
  using Bytes = std::array<std::uint8_t, sizeof(AxisStatus)>;
  EXPECT_EQ(std::bit_cast<Bytes>(status), Bytes{});
}

/// One bit of one axis is flipped: the digest names the axis and, if the flip changes the value of
/// a member, that member.
TEST(StatusDigest, OneFlippedBitNamesItsAxisAndItsMember) {
  Random random(7);
  for (std::uint64_t number = 0; number < test::case_count(5'000, 200'000); ++number) {
    auto statuses = random_statuses(1 + random.below(40), random);
    std::vector<std::uint32_t> rows(statuses.size());
    const StatusDigest before = digest_of(statuses, 1, rows);
    const auto rows_before = rows;
    const auto statuses_before = statuses;
    const std::size_t axis = random.below(statuses.size());
    auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(AxisStatus)>>(statuses[axis]);
    bytes[random.below(bytes.size())] ^= static_cast<std::uint8_t>(1U << random.below(8));
    statuses[axis] = std::bit_cast<AxisStatus>(bytes);
    const StatusDigest after = digest_of(statuses, 1, rows);
    EXPECT_NE(after.image, before.image);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      ASSERT_EQ(rows[row] != rows_before[row], row == axis) << "case " << number;
    }
    for (std::size_t member = 0; member < kStatusMembers; ++member) {
      const auto value = status_members()[member].value;
      ASSERT_EQ(after.members[member] != before.members[member],
                value(statuses[axis]) != value(statuses_before[axis]))
          << "case " << number << ", member " << status_members()[member].name;
    }
  }
}

TEST(StatusDigest, ARowCanCoverSeveralAxes) {
  Random random(11);
  auto statuses = random_statuses(130, random);
  std::vector<std::uint32_t> rows(3);  // 64 + 64 + 2 axes
  const auto image = digest_of(statuses, 64, rows).image;
  EXPECT_EQ(digest_of(statuses, 1, {}).image, image) << "rows do not matter to the image";
  const auto before = rows;
  ++statuses[64].fault_count;
  static_cast<void>(digest_of(statuses, 64, rows));
  EXPECT_EQ(rows[0], before[0]);
  EXPECT_NE(rows[1], before[1]);
  EXPECT_EQ(rows[2], before[2]);
}

TEST(StatusDigest, DependsOnTheOrderOfTheAxes) {
  Random random(13);
  auto statuses = random_statuses(2, random);
  const auto before = digest_of(statuses, 1, {});
  std::swap(statuses[0], statuses[1]);
  const auto after = digest_of(statuses, 1, {});
  EXPECT_NE(after.image, before.image);
  EXPECT_NE(after.members, before.members);
}

}  // namespace
}  // namespace vdrive
