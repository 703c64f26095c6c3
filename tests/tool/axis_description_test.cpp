// SPDX-License-Identifier: Apache-2.0
// The output of `vdrive describe` for given readings.
#include "output/axis_description.hpp"

#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace vdrive::tool {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Le;
using testing::SizeIs;

constexpr ObjectAddress kNewestError{0x1003, 1};

/// @return the default of every object that is described.
client::Readings default_readings() {
  client::Readings readings{.tick = 7, .objects = {}};
  for (const ObjectAddress& object : described_objects()) {
    const std::int64_t value = describe(*find_object(object)).default_value;
    readings.objects.push_back({.object = object, .code = AbortCode::none, .value = value});
  }
  return readings;
}

const client::BenchInfo kBench;

client::AxisInfo some_axis() {
  client::AxisInfo axis;
  axis.id = {1, 1};
  axis.name = "x";
  return axis;
}

client::AxisSnapshot some_status() {
  client::AxisSnapshot status;
  status.id = {1, 1};
  return status;
}

client::ObjectReading& reading_of(client::Readings& readings, ObjectAddress object) {
  return *std::ranges::find(readings.objects, object, &client::ObjectReading::object);
}

TEST(AxisDescription, NeedsTwoRequests) {
  EXPECT_THAT(described_objects(), SizeIs(Le(2 * client::kMostObjectsAtOnce)));
}

// The high word of an error field is manufacturer-specific.
TEST(AxisDescription, TakesTheLastFaultFromTheHistoryElseFromTheErrorCode) {
  client::AxisSnapshot status;
  client::Readings readings = default_readings();
  EXPECT_EQ(last_fault_of(status, readings), std::nullopt);
  status.status.error_code = 0x8611;
  EXPECT_EQ(last_fault_of(status, readings), 0x8611) << "the history was emptied";
  reading_of(readings, kNewestError).value = 0x0001'2310;
  EXPECT_EQ(last_fault_of(status, readings), 0x2310);
}

TEST(AxisDescription, ShowsAnObjectThatWasRefusedWithItsReason) {
  const client::AxisInfo axis = some_axis();
  const client::AxisSnapshot status = some_status();
  client::Readings readings = default_readings();
  EXPECT_THAT(description_text({kBench, axis, status, readings}),
              Contains("  objects     all have their defaults"));
  reading_of(readings, {0x607C, 0}).code = AbortCode::object_does_not_exist;
  const AxisDescription described{kBench, axis, status, readings};
  EXPECT_THAT(description_text(described),
              AllOf(Contains("  objects     1 differs from the default"),
                    Contains(AllOf(HasSubstr("0x607C"), HasSubstr("refused: ")))));
  const Json json = description_json(described);
  ASSERT_THAT(json["objects"], SizeIs(1));
  EXPECT_EQ(json["objects"][0]["code"], "0x06020000");
  EXPECT_EQ(json["objects_tick"], 7);
}

TEST(AxisDescription, SaysThatTheTickOfAnOldFaultIsNotKept) {
  const client::AxisInfo axis = some_axis();
  const client::AxisSnapshot status = some_status();
  client::Readings readings = default_readings();
  reading_of(readings, kNewestError).value = 0x2310;
  const AxisDescription described{kBench, axis, status, readings};
  EXPECT_THAT(description_text(described),
              Contains("  last fault  0x2310 continuous over-current, at a tick that is no "
                       "longer known, reset"));
  EXPECT_TRUE(description_json(described)["fault"]["tick"].is_null());
}

}  // namespace
}  // namespace vdrive::tool
