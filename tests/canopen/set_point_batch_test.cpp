// SPDX-License-Identifier: Apache-2.0
#include "bridge/set_point_batch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

constexpr ObjectAddress kWord{0x6040, 0};
constexpr ObjectAddress kTarget{0x607A, 0};
constexpr ObjectAddress kSpeed{0x6081, 0};

using Values = std::vector<DriveValue>;

/// The values of a set-point as (index, value), the controlword last.
std::vector<std::pair<int, std::int64_t>> content_of(const client::SetPoint& point) {
  std::vector<std::pair<int, std::int64_t>> content;
  for (const client::ObjectValue& value : point.objects) {
    content.emplace_back(value.object.index, value.value);
  }
  if (point.controlword) content.emplace_back(kWord.index, *point.controlword);
  return content;
}

using Content = std::vector<std::pair<int, std::int64_t>>;

TEST(SetPointBatch, PutsTheAxesOfAllNodesIntoOneFrame) {
  SetPointBatch batch;
  EXPECT_TRUE(batch.is_empty());
  batch.add(1, Values{{kTarget, 10}, {kWord, 0x0F}});
  batch.add(2, Values{{kWord, 0x06}});
  EXPECT_FALSE(batch.is_empty());
  const auto frames = batch.take();
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_EQ(frames[0].tick, 0U) << "the next one";
  ASSERT_THAT(frames[0].axes, SizeIs(2));
  EXPECT_EQ(frames[0].axes[0].axis, 1);
  EXPECT_EQ(content_of(frames[0].axes[0]), (Content{{0x607A, 10}, {0x6040, 0x0F}}));
  EXPECT_EQ(frames[0].axes[1].axis, 2);
  EXPECT_EQ(content_of(frames[0].axes[1]), (Content{{0x6040, 0x06}}));
  EXPECT_TRUE(batch.is_empty());
  EXPECT_THAT(batch.take(), IsEmpty());
}

TEST(SetPointBatch, AddsWhatComesBeforeTheControlwordToTheSameFrame) {
  SetPointBatch batch;
  batch.add(1, Values{{kSpeed, 5}});
  batch.add(1, Values{{kTarget, 10}, {kWord, 0x1F}});
  const auto frames = batch.take();
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_EQ(content_of(frames[0].axes[0]), (Content{{0x6081, 5}, {0x607A, 10}, {0x6040, 0x1F}}));
}

// Within one frame, the controlword would act on a target that was added after it.
TEST(SetPointBatch, LetsNothingOvertakeAControlword) {
  SetPointBatch batch;
  batch.add(1, Values{{kTarget, 10}, {kWord, 0x1F}});
  batch.add(1, Values{{kTarget, 20}});
  batch.add(2, Values{{kTarget, 30}});
  const auto frames = batch.take();
  ASSERT_THAT(frames, SizeIs(2));
  EXPECT_EQ(content_of(frames[0].axes[0]), (Content{{0x607A, 10}, {0x6040, 0x1F}}));
  EXPECT_EQ(content_of(frames[0].axes[1]), (Content{{0x607A, 30}})) << "the first one of axis 2";
  EXPECT_EQ(content_of(frames[1].axes[0]), (Content{{0x607A, 20}}));
}

// Every controlword runs the power state machine once.
TEST(SetPointBatch, KeepsEveryControlwordInItsOrder) {
  SetPointBatch batch;
  for (const std::int64_t word : {0x06, 0x07, 0x0F}) batch.add(1, Values{{kWord, word}});
  const auto frames = batch.take();
  ASSERT_THAT(frames, SizeIs(3));
  EXPECT_EQ(frames[0].axes[0].controlword, 0x06);
  EXPECT_EQ(frames[1].axes[0].controlword, 0x07);
  EXPECT_EQ(frames[2].axes[0].controlword, 0x0F);
}

// A frame holds 8 further objects per axis.
TEST(SetPointBatch, DividesMoreObjectsThanAFrameTakes) {
  SetPointBatch batch;
  Values values;
  for (std::uint16_t index = 0; index < 10; ++index) {
    values.push_back({{static_cast<std::uint16_t>(0x6080 + index), 0}, index});
  }
  values.push_back({kWord, 0x0F});
  batch.add(1, values);
  const auto frames = batch.take();
  ASSERT_THAT(frames, SizeIs(2));
  EXPECT_THAT(frames[0].axes[0].objects, SizeIs(8));
  EXPECT_FALSE(frames[0].axes[0].controlword) << "it acts behind all of them";
  EXPECT_THAT(frames[1].axes[0].objects, SizeIs(2));
  EXPECT_EQ(frames[1].axes[0].controlword, 0x0F);
}

TEST(SetPointBatch, OfAFloodKeepsTheNewestValuesInABoundedNumberOfFrames) {
  SetPointBatch batch;
  for (std::int64_t value = 0; value < 1000; ++value) batch.add(1, Values{{kTarget, value}});
  const std::uint64_t replaced = batch.replaced();
  const auto frames = batch.take();
  ASSERT_THAT(frames, SizeIs(SetPointBatch::kMostFrames));
  EXPECT_EQ(frames.back().axes[0].objects.at(0).value, 999);
  EXPECT_EQ(replaced, 1000U - SetPointBatch::kMostFrames);
}

}  // namespace
}  // namespace vdrive::canopen
