// SPDX-License-Identifier: Apache-2.0
// The results that `vdrive bench` calculates from its readings.
#include "diagnosis/measurement.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::tool {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;

TEST(Lateness, CountsInTheBinsOfTheService) {
  Lateness sut;
  sut.add(-3us);    // early: bin 0, below 1 us
  sut.add(999ns);   // bin 0
  sut.add(1us);     // bin 1, below 2 us
  sut.add(3999ns);  // bin 2, below 4 us
  sut.add(1ms);     // 1,000 us: bin 10, below 1,024 us
  sut.add(2h);      // beyond the last bin
  EXPECT_EQ(sut.bins[0], 2U);
  EXPECT_EQ(sut.bins[1], 1U);
  EXPECT_EQ(sut.bins[2], 1U);
  EXPECT_EQ(sut.bins[10], 1U);
  EXPECT_EQ(sut.bins[31], 1U);
  EXPECT_EQ(sut.count(), 6U);
}

TEST(Lateness, InterpolatesQuantilesInsideABin) {
  Lateness sut;
  sut.bins[4] = 90;                            // 8 to 16 us
  sut.bins[7] = 10;                            // 64 to 128 us
  EXPECT_DOUBLE_EQ(sut.quantile(0.45), 12.0);  // middle of the first bin
  EXPECT_DOUBLE_EQ(sut.quantile(0.9), 16.0);
  EXPECT_DOUBLE_EQ(sut.quantile(0.95), 96.0);  // middle of the second one
  EXPECT_DOUBLE_EQ(sut.most(), 128.0);
}

TEST(Lateness, WithoutTicksIsZero) {
  EXPECT_EQ(Lateness().quantile(0.5), 0.0);
  EXPECT_EQ(Lateness().most(), 0.0);
}

/// 50 ns per axis and tick: 20,000 of them fit into a millisecond.
Measurement measurement() {
  Measurement measured;
  measured.bare.add(9us);
  measured.ticks.add(70us);
  measured.steps = {.median = 50.0, .p99 = 80.0, .per_second = 19'000.0};
  measured.tick_of_an_axis = 50.0;
  measured.streams = {{.axes = 64, .samples = 4'000},
                      {.axes = 256, .samples = 4'000, .overrun_share = 0.001},
                      {.axes = 1'024, .samples = 3'900, .missed = 100}};
  return measured;
}

TEST(Measurement, GivesTheNumberOfAxesThatTheMachineHolds) {
  EXPECT_EQ(measurement().axes_of_a_core(), 20'000U);
  EXPECT_EQ(measurement().axes_with_status(), 256U);
  EXPECT_EQ(Measurement().axes_of_a_core(), 0U);
  EXPECT_EQ(Measurement().axes_with_status(), 0U);
}

TEST(Measurement, IsIncompleteWithLateTicksOrWithoutSamples) {
  EXPECT_FALSE(
      (StatusStreamFigures{.axes = 1, .samples = 1'000, .overrun_share = 0.002}).is_whole());
  EXPECT_FALSE((StatusStreamFigures{.axes = 1}).is_whole());
}

TEST(Measurement, IsPrintedAsOneJsonObject) {
  const Json json = measurement_json(measurement());
  EXPECT_EQ(json["axes_with_status"], 256);
  EXPECT_EQ(json["axes_of_a_core"], 20'000);
  EXPECT_EQ(json["status"][2]["missed"], 100);
  EXPECT_EQ(json["steps"]["per_second"], 19'000.0);
  EXPECT_EQ(json["lateness_of_ticks"]["max_us"], 128.0);
  EXPECT_EQ(json["lateness_of_a_bare_loop"]["max_us"], 16.0);
}

TEST(Measurement, IsPrintedAsATable) {
  const auto lines = measurement_lines(measurement());
  // 100 of 4,000 ticks are 2.5 %.
  EXPECT_THAT(lines, Contains(HasSubstr("1024 axes: 2.50 % of the ticks missed")));
  EXPECT_THAT(lines, Contains(HasSubstr("can run 256 axes")));
  EXPECT_THAT(measurement_lines({}), Contains(HasSubstr("too busy")));
  EXPECT_THAT(lines, Contains(HasSubstr("p50 50.0 us, p99 80.0 us, 19000 a second")));
}

}  // namespace
}  // namespace vdrive::tool
