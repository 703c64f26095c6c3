// SPDX-License-Identifier: Apache-2.0
#include "bridge/node_ids.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::HasSubstr;

std::vector<client::AxisInfo> axes_of_bench(std::uint32_t bench,
                                            const std::vector<std::uint16_t>& numbers) {
  std::vector<client::AxisInfo> axes;
  for (const std::uint16_t number : numbers) axes.emplace_back().id = {bench, number};
  return axes;
}

TEST(NodeIds, AreNumbersOfAxesWithTheOffsetOfTheirBench) {
  NodeIds ids;
  EXPECT_EQ(ids.text(), "0 nodes");
  EXPECT_EQ(ids.add(axes_of_bench(1, {1, 2, 3}), 0), std::nullopt);
  EXPECT_EQ(ids.text(), "3 nodes (1 to 3)");
  EXPECT_EQ(ids.add(axes_of_bench(2, {1, 3}), 10), std::nullopt);
  EXPECT_EQ(ids.text(), "5 nodes (1 to 3, 11, 13)");
  EXPECT_EQ(node_id_of({2, 3}, 10), 13);
}

TEST(NodeIds, TakeANegativeOffset) {
  NodeIds ids;
  EXPECT_EQ(ids.add(axes_of_bench(1, {1001}), -1000), std::nullopt);
  EXPECT_EQ(ids.text(), "1 node (1)");
}

TEST(NodeIds, NameAxisNodeAndLimitOutsideOfTheRange) {
  NodeIds ids;
  const auto refused = ids.add(axes_of_bench(1, {127, 128}), 0);
  ASSERT_TRUE(refused);
  EXPECT_THAT(*refused, HasSubstr("axis 1.128 would be node 128: node ids are 1 to 127"));
  EXPECT_THAT(*refused, HasSubstr("--node-offset"));
  EXPECT_EQ(ids.text(), "0 nodes") << "all axes of a bench, or none";
  EXPECT_THAT(ids.add(axes_of_bench(1, {5}), -5).value_or(""), HasSubstr("would be node 0"));
}

TEST(NodeIds, NameTheAxisThatHasTheNodeAlready) {
  NodeIds ids;
  EXPECT_EQ(ids.add(axes_of_bench(1, {1, 2}), 0), std::nullopt);
  EXPECT_THAT(ids.add(axes_of_bench(2, {3, 2}), 0).value_or(""),
              HasSubstr("axis 2.2 would be node 2, which is axis 1.2"));
  EXPECT_EQ(ids.text(), "2 nodes (1 to 2)");
}

TEST(NodeIds, AreFreeAgainWhenTheirBenchHasGone) {
  NodeIds ids;
  EXPECT_EQ(ids.add(axes_of_bench(1, {1, 2}), 0), std::nullopt);
  ids.remove(1);
  EXPECT_EQ(ids.add(axes_of_bench(2, {2}), 0), std::nullopt);
  EXPECT_EQ(ids.text(), "1 node (2)");
}

}  // namespace
}  // namespace vdrive::canopen
