// SPDX-License-Identifier: Apache-2.0
// The findings of a comparison of two journals.
#include "support/journal_comparison.hpp"

#include "journal/journal_file.hpp"
#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

namespace vdrive::test {
namespace {

using service::JournalChange;
using service::JournalSnapshot;
using testing::HasSubstr;

enum class End : std::uint8_t { written, missing };

/// The content of a journal of one axis.
struct Content {
  std::string configuration = "bench:\n  number: 1\nnetwork:\n  domain: 7\naxes:\n  - number: 1\n";
  std::int64_t value = 5'000;       ///< written before the first tick
  std::uint32_t last_velocity = 1;  ///< checksum of the last tick
  std::uint64_t lost = 0;           ///< ticks before the snapshot
  std::byte state{};                ///< last byte of the snapshot, which has two
  End end = End::written;
};

class JournalComparisonOf : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const Content& content) {
    const std::filesystem::path path = directory_.path() / name;
    std::ofstream file(path, std::ios::binary);
    service::JournalWriter writer(
        [&file](std::span<const std::byte> bytes) {
          for (const std::byte byte : bytes) file.put(static_cast<char>(byte));
        },
        {.layout = 1, .rows = 1, .version = "1", .configuration = content.configuration});
    writer.write(JournalSnapshot{.cause = JournalSnapshot::Cause::start,
                                 .tick = 4,
                                 .lost = content.lost,
                                 .state = {{}, content.state}});
    writer.write(JournalChange{.address = {0x6081, 0}, .value = content.value});
    StatusDigest digest{.image = 1};
    writer.write_tick(5, digest, std::array{1U});
    digest.image = content.last_velocity + 1;
    digest.members[5] = content.last_velocity;
    writer.write_tick(6, digest, std::array{content.last_velocity});
    if (content.end == End::written) {
      writer.end();
    } else {
      writer.flush();
    }
    return path;
  }

  JournalComparison compare(const Content& one, const Content& other) {
    return compare_journals(write("one", one), write("other", other));
  }

 private:
  const TemporaryDirectory directory_;
};

TEST_F(JournalComparisonOf, TheSameRecordsFindsNothing) {
  const JournalComparison found = compare({}, {});
  EXPECT_EQ(found.difference, "");
  EXPECT_EQ(found.ticks, 2U);
  EXPECT_EQ(found.changes, 1U);
  EXPECT_EQ(found.snapshots, 1U);
}

TEST_F(JournalComparisonOf, TwoNetworksFindsNothing) {
  EXPECT_EQ(compare({}, {.configuration = "bench:\n  number: 1\nwire:\n  form: thread\n"
                                          "network:\n  domain: 8\naxes:\n  - number: 1\n"})
                .difference,
            "");
}

TEST_F(JournalComparisonOf, TwoConfigurationsFindsThem) {
  EXPECT_THAT(compare({}, {.configuration = "bench:\n  number: 2\n"}).difference,
              HasSubstr("number: 2"));
}

TEST_F(JournalComparisonOf, TwoChangesNamesTickObjectAndValues) {
  const std::string difference = compare({}, {.value = 6'000}).difference;
  EXPECT_THAT(difference, HasSubstr("record 1, after tick 4: change 1"));
  EXPECT_THAT(difference, HasSubstr("6081h) = 5000 in one"));
  EXPECT_THAT(difference, HasSubstr("6081h) = 6000 in other"));
}

TEST_F(JournalComparisonOf, TwoTicksNamesTheMemberAndTheRow) {
  EXPECT_THAT(compare({}, {.last_velocity = 2}).difference,
              HasSubstr("tick 6 in other: different are velocity_demand_value, row 0"));
}

TEST_F(JournalComparisonOf, TwoSnapshotsNamesTickAndByte) {
  EXPECT_THAT(compare({}, {.state = std::byte{1}}).difference,
              HasSubstr("at tick 4 of 2 bytes, 0 ticks lost before it in other: different from "
                        "byte 1 on"));
}

TEST_F(JournalComparisonOf, JournalsWithoutTheirEndFindsThatItIsMissing) {
  const Content ended_early{.end = End::missing};
  EXPECT_THAT(compare(ended_early, ended_early).difference, HasSubstr("one is not whole"));
  EXPECT_THAT(compare({}, ended_early).difference, HasSubstr("no record in other"));
}

TEST_F(JournalComparisonOf, JournalsWithATornEndFindsIt) {
  const auto one = write("one", {});
  const auto other = write("other", {});
  for (const auto& file : {one, other}) {
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  }
  const std::string difference = compare_journals(one, other).difference;
  EXPECT_THAT(difference, HasSubstr("one is not whole: its last record is tick 6"));
}

TEST_F(JournalComparisonOf, JournalsThatHaveLostTicksFindsTheLoss) {
  const Content slow{.lost = 3};
  EXPECT_THAT(compare(slow, slow).difference, HasSubstr("3 ticks lost"));
}

}  // namespace
}  // namespace vdrive::test
