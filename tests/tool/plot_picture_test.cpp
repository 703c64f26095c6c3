// SPDX-License-Identifier: Apache-2.0
// Reducing samples to pixels, and drawing them.
#include "output/plot_picture.hpp"

#include "base/usage_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Le;
using testing::Not;
using testing::SizeIs;

constexpr std::uint16_t kEnabledWord = 0x0237;
constexpr std::uint16_t kFaultWord = 0x0218;

client::AxisSnapshot plotted_sample(std::uint64_t tick, std::int32_t position) {
  client::AxisSnapshot sample;
  sample.id = {1, 1};
  sample.tick = tick;
  sample.status.ds402_statusword = kEnabledWord;
  sample.status.load_position_actual_value = position;
  return sample;
}

std::vector<std::string> names_in(const std::vector<PlotColumn>& columns) {
  std::vector<std::string> names;
  for (const PlotColumn& column : columns) names.push_back(column.name);
  return names;
}

std::string columns_refused(const std::string& text) {
  try {
    static_cast<void>(parse_plot_columns(text));
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(PlotColumns, AreNamedAsInARecordingOrAsAnObject) {
  EXPECT_THAT(names_in(parse_plot_columns("velocity,0x6062,torque_demand,fault_count,606Ch")),
              ElementsAre("load_velocity_actual_value", "position_demand_value", "torque_demand",
                          "fault_count"))
      << "606Ch is the velocity, and is drawn once";
}

TEST(PlotColumns, OfAnUnknownNameNameTheNearestOneOrAll) {
  EXPECT_EQ(columns_refused("torque_demnd"),
            "--columns: a recording has no column 'torque_demnd' (did you mean 'torque_demand'?)");
  EXPECT_THAT(columns_refused("profile_velocity"),
              AllOf(HasSubstr("no column 'profile_velocity'"), HasSubstr("position_demand_value"),
                    HasSubstr("fault_count")))
      << "an object that the status does not have";
}

TEST(PlotColumns, OfOneQuantityShareAPanel) {
  EXPECT_EQ(count_panels(usual_plot_columns()), 4U) << "position, velocity, torque, error";
  EXPECT_EQ(count_panels(parse_plot_columns("position,0x6062,0x3572")), 1U);
  EXPECT_EQ(count_panels(parse_plot_columns("error_code,op_mode_actual")), 2U);
}

// Ten samples per pixel column: 1000 samples in 100 columns.
TEST(PlotReduction, KeepsThePeakOfEachColumnOfPixelsInItsTick) {
  PlotReduction reduction(parse_plot_columns("position"), 0, 999, 100);
  for (std::uint64_t tick = 0; tick < 1'000; ++tick) {
    reduction.take(
        plotted_sample(tick, tick == 505 ? 9'000 : static_cast<std::int32_t>(tick % 10)));
  }
  const PlotTraces traces = std::move(reduction).finish();
  EXPECT_EQ(traces.samples, 1'000U);
  const std::vector<PlotPoint>& points = traces.traces.at(0).points;
  EXPECT_THAT(points, SizeIs(Le(201U))) << "two for each column, and the last sample";
  EXPECT_THAT(points, testing::Contains(PlotPoint{505, 9'000}));
  EXPECT_EQ(points.front(), (PlotPoint{0, 0}));
  EXPECT_EQ(points.back(), (PlotPoint{999, 9}));
  EXPECT_TRUE(std::ranges::is_sorted(points, {}, &PlotPoint::tick));
}

// Fewer samples than pixel columns.
TEST(PlotReduction, KeepsEverySampleOfAShortRecording) {
  PlotReduction reduction(parse_plot_columns("position"), 10, 14, 800);
  for (const std::uint64_t tick : {10U, 11U, 13U, 14U}) {
    reduction.take(plotted_sample(tick, static_cast<std::int32_t>(tick * tick)));
  }
  EXPECT_THAT(
      std::move(reduction).finish().traces.at(0).points,
      ElementsAre(PlotPoint{10, 100}, PlotPoint{11, 121}, PlotPoint{13, 169}, PlotPoint{14, 196}));
}

TEST(PlotReduction, OfAValueThatStaysKeepsItsFirstAndLastSample) {
  PlotReduction reduction(parse_plot_columns("position"), 0, 99, 50);
  for (std::uint64_t tick = 0; tick < 100; ++tick) reduction.take(plotted_sample(tick, 7));
  EXPECT_THAT(std::move(reduction).finish().traces.at(0).points,
              ElementsAre(PlotPoint{0, 7}, PlotPoint{99, 7}));
}

TEST(PlotReduction, PassesOverSamplesOutsideOfTheEdges) {
  PlotReduction reduction(parse_plot_columns("position"), 5, 7, 10);
  for (std::uint64_t tick = 0; tick < 20; ++tick) {
    reduction.take(plotted_sample(tick, static_cast<std::int32_t>(tick)));
  }
  const PlotTraces traces = std::move(reduction).finish();
  EXPECT_EQ(traces.samples, 3U);
  EXPECT_EQ(traces.traces.at(0).points.front(), (PlotPoint{5, 5}));
  EXPECT_EQ(traces.traces.at(0).points.back(), (PlotPoint{7, 7}));
}

// All ticks share one pixel column; the fault lasts one tick.
TEST(PlotReduction, ShowsAFaultThatIsShorterThanAPixel) {
  PlotReduction reduction(parse_plot_columns("position"), 0, 9, 1);
  for (std::uint64_t tick = 0; tick < 10; ++tick) {
    client::AxisSnapshot sample = plotted_sample(tick, 0);
    if (tick == 4) {
      sample.status.ds402_statusword = kFaultWord;
      sample.status.error_code = 0x8611;
    }
    reduction.take(sample);
  }
  const PlotTraces traces = std::move(reduction).finish();
  ASSERT_THAT(traces.states, SizeIs(1));
  EXPECT_EQ(traces.states[0].state, PowerState::fault);
  ASSERT_THAT(traces.faults, SizeIs(1));
  EXPECT_EQ(traces.faults[0].tick, 4U);
  EXPECT_EQ(traces.faults[0].code, 0x8611);
}

TEST(PlotReduction, DoesNotCallAFaultFromBeforeTheEdgeNew) {
  PlotReduction reduction(parse_plot_columns("position"), 5, 9, 10);
  for (std::uint64_t tick = 0; tick < 10; ++tick) {
    client::AxisSnapshot sample = plotted_sample(tick, 0);
    sample.status.error_code = 0x8611;
    reduction.take(sample);
  }
  EXPECT_THAT(std::move(reduction).finish().faults, SizeIs(0));
}

PlotTraces faulted_traces() {
  PlotReduction reduction(usual_plot_columns(), 1'000, 2'999, plot_bins(kUsualPlotWidth, 7));
  for (std::uint64_t tick = 1'000; tick < 3'000; ++tick) {
    client::AxisSnapshot sample = plotted_sample(tick, static_cast<std::int32_t>(tick));
    sample.status.torque_actual_value = 125;
    if (tick >= 2'000) {
      sample.status.ds402_statusword = kFaultWord;
      sample.status.error_code = 0x8611;
    }
    reduction.take(sample);
  }
  return std::move(reduction).finish();
}

TEST(PlotPicture, HasTitleStatesFaultUnitsAndLegend) {
  const std::string svg = plot_svg(faulted_traces(), {.title = "axis 1.1 x", .origin = 1'000});
  EXPECT_THAT(svg, AllOf(HasSubstr("<title>axis 1.1 x</title>"), HasSubstr(">Operation enabled<"),
                         HasSubstr(">Fault<"), HasSubstr(">fault 8611h following error<"),
                         HasSubstr(">position [UU]<"), HasSubstr(">velocity [UU/s]<"),
                         HasSubstr(">torque and current [% of rated]<"),
                         HasSubstr(">following error [UU]<")));
  EXPECT_THAT(svg, AllOf(HasSubstr(">demand 6062h<"), HasSubstr(">actual 6064h<"),
                         HasSubstr(">drive time [s]<"), HasSubstr(">1.0<")))
      << "2 s of ticks of 1 ms";
  EXPECT_THAT(svg, testing::StartsWith("<svg "));
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
}

TEST(PlotPicture, FollowsTheColourSchemeOfTheViewerOnItsOwnBackground) {
  const std::string svg = plot_svg(faulted_traces(), {.title = "x", .origin = 1'000});
  EXPECT_THAT(
      svg, AllOf(HasSubstr("@media (prefers-color-scheme:dark)"), HasSubstr("<rect class=\"p\"")));
}

TEST(PlotPicture, IsTheSameForTheSameTraces) {
  const PlotStyle style{.title = "x", .origin = 1'000};
  EXPECT_EQ(plot_svg(faulted_traces(), style), plot_svg(faulted_traces(), style));
}

TEST(PlotPicture, EscapesItsTexts) {
  const std::string svg = plot_svg(
      faulted_traces(), {.title = "<b>\"a\" & b</b>\n\x1B", .note = "</text>", .origin = 1'000});
  EXPECT_THAT(svg,
              AllOf(HasSubstr("&lt;b&gt;&quot;a&quot; &amp; b&lt;/b&gt;\\n\\x1B"),
                    HasSubstr("&lt;/text&gt;"), Not(HasSubstr("<b>")), Not(HasSubstr("\x1B"))));
}

// The worst case: values and states that change with each sample.
TEST(PlotPicture, OfALongRecordingStaysSmall) {
  constexpr std::size_t kLimit = 300'000;  // bytes
  constexpr std::uint64_t kSamples = 200'000;
  for (const std::uint32_t width : {kUsualPlotWidth, kLargestPlotSide}) {
    const std::vector<PlotColumn> columns = usual_plot_columns();
    PlotReduction reduction(columns, 0, kSamples - 1, plot_bins(width, columns.size()));
    for (std::uint64_t tick = 0; tick < kSamples; ++tick) {
      const std::int32_t value = tick % 2 == 0 ? 2'000'000'000 : -2'000'000'000;
      client::AxisSnapshot sample = plotted_sample(tick, value);
      sample.status.position_demand_value = -value;
      sample.status.velocity_demand_value = value;
      sample.status.load_velocity_actual_value = -value;
      sample.status.load_position_error_value = value;
      sample.status.torque_demand = tick % 2 == 0 ? 1'000 : -1'000;
      sample.status.torque_actual_value = tick % 2 == 0 ? -1'000 : 1'000;
      if (tick / 1'000 % 2 == 0) sample.status.ds402_statusword = kFaultWord;
      if (tick / 1'000 % 2 == 0) sample.status.error_code = 0x8611;
      reduction.take(sample);
    }
    const PlotTraces traces = std::move(reduction).finish();
    EXPECT_EQ(traces.faults.size(), kMostPlotFaults);
    EXPECT_EQ(traces.faults_left_out, 50U) << "100 faults in all";
    const std::string svg = plot_svg(traces, {.title = "x", .width = width});
    EXPECT_LT(svg.size(), kLimit) << width;
  }
}

TEST(PlotPicture, OfOneSampleIsDrawn) {
  PlotReduction reduction(usual_plot_columns(), 5, 5, 100);
  reduction.take(plotted_sample(5, 3));
  const std::string svg = plot_svg(std::move(reduction).finish(), {.title = "x", .origin = 5});
  EXPECT_THAT(svg, AllOf(Not(HasSubstr("nan")), Not(HasSubstr("inf"))));
}

}  // namespace
}  // namespace vdrive::tool
