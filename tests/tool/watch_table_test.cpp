// SPDX-License-Identifier: Apache-2.0
// The table of `watch`: the columns for each width; no row is wider than the terminal.
#include "output/watch_view.hpp"
#include "terminal/columns.hpp"
#include "terminal/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <limits>

namespace vdrive::tool {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

client::AxisSnapshot axis_of(std::uint16_t number) {
  client::AxisSnapshot axis;
  axis.id = {1, number};
  axis.status.ds402_statusword = 0x0637;
  axis.status.op_mode_actual = 1;
  return axis;
}

/// Axes 1.1 to 1.`count` at tick 42, each with the longest numbers possible.
client::Observation observation(std::uint16_t count) {
  client::Observation sample;
  sample.tick = 42;
  for (std::uint16_t number = 1; number <= count; ++number) {
    client::AxisSnapshot& axis = sample.axes.emplace_back(axis_of(number));
    axis.status.load_position_actual_value = std::numeric_limits<std::int32_t>::min();
    axis.status.load_velocity_actual_value = std::numeric_limits<std::int32_t>::min();
    axis.status.position_demand_value = std::numeric_limits<std::int32_t>::max();
  }
  return sample;
}

std::map<client::AxisId, AxisLabel> labels_of(const client::Observation& sample,
                                              const std::string& name) {
  std::map<client::AxisId, AxisLabel> labels;
  for (const client::AxisSnapshot& axis : sample.axes) labels[axis.id] = {name, {}};
  return labels;
}

std::vector<LiveLine> table_of(const client::Observation& sample, TerminalSize size) {
  return watch_table(sample, labels_of(sample, "gantry_left"), size);
}

TEST(WatchTable, FitsTheWidthAndHeightOfTheTerminal) {
  const client::Observation sample = observation(20);
  const auto labels = labels_of(sample, "轴_with_a_long_name_of_many_characters");
  for (std::size_t columns = 2; columns <= 300; ++columns) {
    for (const std::size_t rows : {1U, 3U, 10U, 22U, 100U}) {
      const auto lines = watch_table(sample, labels, {columns, rows});
      EXPECT_LE(lines.size(), std::max<std::size_t>(rows, 3));
      for (const LiveLine& line : lines) EXPECT_LT(display_width(line.text), columns) << line.text;
    }
  }
}

// 4 + 1 + 11 + 1 + 12 + 2 = 31 columns before the state, and 33 for "Operation enabled: target
// reached".
TEST(WatchTable, ShowsPositionVelocityAndStateIn65Columns) {
  client::Observation sample;
  sample.axes = {axis_of(1)};
  sample.axes[0].status.load_position_actual_value = -123'456;
  sample.axes[0].status.load_velocity_actual_value = 123'456;
  auto labels = labels_of(sample, "axis");
  labels[{1, 1}].unit = {.kind = client::UnitKind::linear, .name = "mm", .size = 1'000.0};
  EXPECT_EQ(watch_table(sample, labels, {65, 24}).at(2).text,
            "1.1  -123.456 mm 123.456 mm/s  Operation enabled: target reached");
}

TEST(WatchTable, HasMoreColumnsOnAWiderTerminal) {
  const client::Observation sample = observation(1);
  const auto header = [&](std::size_t columns) {
    return table_of(sample, {columns, 24}).at(1).text;
  };
  EXPECT_THAT(header(79), Not(HasSubstr("in UU")));
  EXPECT_THAT(header(80), HasSubstr("in UU"));
  EXPECT_THAT(header(89), Not(HasSubstr("word")));
  EXPECT_THAT(header(90), HasSubstr("word"));
  EXPECT_THAT(header(100), HasSubstr("name"));
  EXPECT_THAT(header(120), HasSubstr("torque"));
  EXPECT_THAT(header(160), HasSubstr("demand"));
}

// A quarter of 4096 user units is 90 deg.
TEST(WatchTable, ShowsPositionAndVelocityInTheUnitOfEachAxis) {
  client::Observation sample;
  sample.axes = {axis_of(1), axis_of(2)};
  sample.axes[0].status.load_position_actual_value = 1'024;
  sample.axes[1].status.load_position_actual_value = 1'024;
  auto labels = labels_of(sample, "axis");
  labels[{1, 2}].unit = {.kind = client::UnitKind::linear, .name = "mm", .size = 1'000.0};
  const auto lines = watch_table(sample, labels, {80, 24});
  EXPECT_EQ(lines.at(2).text,
            "1.1    90.00 deg      1024   0.00 deg/s  Operation enabled: target reached");
  EXPECT_EQ(lines.at(3).text,
            "1.2     1.024 mm      1024   0.000 mm/s  Operation enabled: target reached");
}

TEST(WatchTable, IsRedOnAFaultOfAnAxisThatIsLeftOut) {
  client::Observation sample = observation(5);
  sample.axes[4].status.ds402_statusword = 0x0218;
  sample.axes[4].status.error_code = 0x8611;
  const auto whole = table_of(sample, {89, 24});
  ASSERT_THAT(whole, SizeIs(7));
  EXPECT_THAT(whole[6].text, HasSubstr("Fault 0x8611 following error"));
  EXPECT_EQ(whole[6].color, Color::red);
  EXPECT_EQ(whole[5].color, std::nullopt);
  // Five rows: title, header, two axes, and a row for the three others.
  const auto cut = table_of(sample, {80, 5});
  ASSERT_THAT(cut, SizeIs(5));
  EXPECT_EQ(cut[4], (LiveLine{"... 3 more axes, 1 with a fault", Color::red}));
}

/// The first cell of each row below title and header.
std::vector<std::string> axes_of(const std::vector<LiveLine>& lines) {
  std::vector<std::string> axes;
  for (std::size_t i = 2; i < lines.size(); ++i) {
    axes.push_back(lines[i].text.substr(0, lines[i].text.find(' ')));
  }
  return axes;
}

TEST(WatchTable, IsSortedBySelectedColumn) {
  client::Observation sample;
  sample.axes = {axis_of(1), axis_of(2), axis_of(3)};
  sample.axes[0].status.load_velocity_actual_value = 5;
  sample.axes[1].status.load_velocity_actual_value = -70;
  sample.axes[0].status.load_position_actual_value = 9;
  sample.axes[2].status.ds402_statusword = 0x0218;
  const auto labels = labels_of(sample, "axis");
  const auto sorted = [&](WatchChoice choice) {
    return watch_table(sample, labels, {80, 24}, choice);
  };
  EXPECT_THAT(axes_of(sorted({})), ElementsAre("1.1", "1.2", "1.3"));
  EXPECT_THAT(axes_of(sorted({.is_reversed = true})), ElementsAre("1.3", "1.2", "1.1"));
  EXPECT_THAT(axes_of(sorted({.sort = WatchSort::velocity})), ElementsAre("1.2", "1.1", "1.3"));
  EXPECT_THAT(axes_of(sorted({.sort = WatchSort::position})), ElementsAre("1.2", "1.3", "1.1"));
  EXPECT_THAT(axes_of(sorted({.sort = WatchSort::state})), ElementsAre("1.3", "1.1", "1.2"));
  EXPECT_THAT(axes_of(sorted({.only_faults = true})), ElementsAre("1.3"));
  EXPECT_THAT(
      sorted({.sort = WatchSort::velocity, .is_reversed = true, .only_faults = true})[0].text,
      testing::EndsWith(", by velocity reversed, faults only"));
}

// Six rows: title, header, three axes, and a row that counts the others.
TEST(WatchTable, HasPagesWhereNotAllAxesFit) {
  const client::Observation sample = observation(8);
  const auto labels = labels_of(sample, "axis");
  const auto page = [&](std::size_t first) {
    return axes_of(watch_table(sample, labels, {80, 6}, {.first = first}));
  };
  EXPECT_THAT(page(0), ElementsAre("1.1", "1.2", "1.3", "..."));
  EXPECT_THAT(page(3), ElementsAre("1.4", "1.5", "1.6", "..."));
  EXPECT_THAT(page(6), ElementsAre("1.7", "1.8", "..."));
  EXPECT_THAT(page(1'000), ElementsAre("1.7", "1.8", "...")) << "beyond the end: the last page";
}

TEST(WatchTable, ReportsThatNoAxisHasAFault) {
  const client::Observation sample = observation(2);
  const auto lines =
      watch_table(sample, labels_of(sample, "axis"), {80, 24}, {.only_faults = true});
  ASSERT_THAT(lines, SizeIs(3));
  EXPECT_EQ(lines[2].text, "no axis has a fault");
}

TEST(Keys, AreLettersAndThePageKeys) {
  std::string typed = "xs\x1b[6~\x1b[5~q";
  EXPECT_EQ(take_key(typed), Key::sort) << "x is no key";
  EXPECT_EQ(take_key(typed), Key::next_page);
  EXPECT_EQ(take_key(typed), Key::previous_page);
  EXPECT_EQ(take_key(typed), Key::quit);
  EXPECT_EQ(take_key(typed), std::nullopt);
  typed = "\x1b[6";
  EXPECT_EQ(take_key(typed), std::nullopt) << "the rest of the sequence is still to come";
  typed += "~";
  EXPECT_EQ(take_key(typed), Key::next_page);
}

TEST(Columns, CutTextAtCharactersAndCountWideOnesTwice) {
  EXPECT_EQ(display_width("a轴b"), 4U);
  EXPECT_EQ(clipped("abcdef", 6), "abcdef");
  EXPECT_EQ(clipped("abcdef", 5), "abc..");
  EXPECT_EQ(clipped("轴轴轴", 5), "轴..") << "half a character does not fit";
  EXPECT_EQ(clipped("abc", 1), "a");
  EXPECT_EQ(padded("轴", 3), "轴 ");
  EXPECT_EQ(aligned_right("轴", 3), " 轴");
}

// A paused bench stays at one tick, which both the answer to a request and the first frame of the
// stream show.
TEST(WatchView, ShowsATickThatComesTwiceInOneLine) {
  constexpr std::chrono::seconds kLongerThanAPeriod{1};
  for (const auto form : {WatchView::Form::lines, WatchView::Form::json}) {
    client::Observation sample;
    sample.tick = 42;
    sample.axes = {axis_of(1)};
    Terminal terminal;
    WatchView view(terminal, labels_of(sample, "lift"), form);
    WatchView::Clock::time_point now{};
    view.take(sample);
    EXPECT_TRUE(view.refresh(now));
    view.take(sample);
    EXPECT_FALSE(view.refresh(now += kLongerThanAPeriod));
    sample.axes[0].status.load_position_actual_value = 1;  // for example, a snapshot was restored
    view.take(sample);
    EXPECT_TRUE(view.refresh(now += kLongerThanAPeriod));
    sample.axes[0].tick = 43;
    view.take(sample);
    EXPECT_TRUE(view.refresh(now += kLongerThanAPeriod));
  }
}

}  // namespace
}  // namespace vdrive::tool
