// SPDX-License-Identifier: Apache-2.0
// Every later 1.x reads recordings of version 1.0 (docs/reference/compatibility.md).
#include "convert.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

class RecordingOf1_0 : public testing::TestWithParam<std::string> {};

TEST_P(RecordingOf1_0, IsReadWithItsAxesAndValues) {
  std::vector<client::Observation> samples;
  const recording::Contents contents =
      recording::read_recording(VDRIVE_SOURCE_DIR "/tests/data/kept/1.0/run." + GetParam(),
                                [&samples](const client::Observation& sample) {
                                  samples.push_back(sample);
                                });
  EXPECT_EQ(contents.cut, "");
  EXPECT_EQ(contents.rows, 42U);
  ASSERT_EQ(contents.benches.size(), 1U);
  const recording::RecordedBench& bench = contents.benches[0];
  EXPECT_EQ(bench.number, 7U);
  EXPECT_EQ(bench.period, std::chrono::milliseconds(1));
  ASSERT_EQ(bench.axes.size(), 2U);
  EXPECT_EQ(bench.axes[0].name, "lift");
  ASSERT_TRUE(bench.axes[0].unit);
  EXPECT_EQ(bench.axes[0].unit->name, "mm");
  EXPECT_EQ(bench.axes[0].unit->size, 819.2);
  EXPECT_EQ(bench.axes[1].name, "table");

  ASSERT_EQ(samples.size(), 21U);
  const client::Observation& last = samples.back();
  EXPECT_EQ(last.tick, samples.front().tick + 20);
  EXPECT_EQ(last.missed, 0U);
  ASSERT_EQ(last.axes.size(), 2U);
  EXPECT_EQ(last.axes[0].status.load_position_actual_value, 819);
  EXPECT_EQ(last.axes[1].status.load_position_actual_value, 1'000);
  EXPECT_EQ(last.axes[1].status.ds402_statusword, 0x231);
  EXPECT_EQ(last.axes[1].status.fault_count, 1U);
}

INSTANTIATE_TEST_SUITE_P(Format, RecordingOf1_0, testing::Values("mcap", "csv", "jsonl"),
                         [](const auto& format) {
                           return format.param;
                         });

}  // namespace
}  // namespace vdrive::test
