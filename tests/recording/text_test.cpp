// SPDX-License-Identifier: Apache-2.0
// Recordings in text formats: CSV and JSON lines.
#include "csv_field.hpp"
#include "recording/sample_recording.hpp"
#include "text_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace vdrive::test {
namespace {

using namespace recording;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class Text : public testing::TestWithParam<Format> {
 protected:
  /// @return the error of reading a text.
  [[nodiscard]] static std::string refusal_of(const std::string& text) {
    try {
      (void)read_back(GetParam(), text);
    } catch (const RecordingError& error) {
      return error.what();
    }
    return "";
  }

  const std::vector<RecordedBench> benches_ = benches_of(2, 3);
  const std::vector<client::Observation> samples_ = samples_of(benches_[0], 12);
  const std::string text_ = text_of(GetParam(), benches_, samples_);
};

TEST_P(Text, IsReadBackUnchanged) {
  const Read read = read_back(GetParam(), text_);
  expect_equal(read.samples, samples_, false);
  EXPECT_EQ(read.contents.rows, 36U);
  ASSERT_EQ(read.contents.benches.size(), 1U);
  EXPECT_EQ(read.contents.benches[0].axes.size(), 3U);
  EXPECT_EQ(read.contents.benches[0].axes[1].name, "lift \"2\", left");
}

TEST_P(Text, IsWrittenTheSameAfterReading) {
  const Read read = read_back(GetParam(), text_);
  EXPECT_EQ(text_of(GetParam(), read.contents.benches, read.samples), text_);
}

TEST_P(Text, WithAnIncompleteLastLineIsRefusedWithItsNumber) {
  const auto lines = static_cast<std::size_t>(std::ranges::count(text_, '\n'));
  const std::string torn = text_.substr(0, text_.size() - 3);
  EXPECT_THAT(refusal_of(torn), AllOf(HasSubstr("line " + std::to_string(lines)),
                                      HasSubstr("the last line has no line break")));
}

TEST_P(Text, ThatEndsBetweenTwoAxesOfATickIsRefusedWithTheAxesThatItHas) {
  const std::string cut = text_.substr(0, text_.rfind('\n', text_.size() - 2) + 1);
  EXPECT_THAT(refusal_of(cut), HasSubstr("the tick " + std::to_string(samples_.back().tick) +
                                         " of bench 1 has 2 of 3 axes: it is incomplete"));
}

TEST_P(Text, WithARepeatedPartIsRefusedWithAxisAndTicks) {
  const std::size_t second = text_.find('\n') + 1;
  const std::string rows = GetParam() == Format::csv ? text_.substr(second) : text_;
  EXPECT_THAT(
      refusal_of(text_ + rows),
      AllOf(HasSubstr("line "), HasSubstr("the tick 1001 of the axis 1.1 follows the tick " +
                                          std::to_string(samples_.back().tick))));
  const std::string last = text_.substr(text_.rfind('\n', text_.size() - 2) + 1);
  EXPECT_THAT(refusal_of(text_ + last), HasSubstr("the axis 1.3 has the tick"));
}

TEST_P(Text, WithAnIncompleteLineInTheMiddleIsRefusedWithItsNumber) {
  std::string text = text_;
  const std::size_t second = text.find('\n', text.find('\n') + 1);
  text.erase(second - 40, 40);
  EXPECT_THAT(refusal_of(text), HasSubstr("line 2: "));
}

TEST_P(Text, WithAValueOutOfRangeIsRefusedWithRangeAndColumn) {
  std::string text = text_;
  // The first row's statusword has 16 bits; its name appears once in a CSV, in each line of JSON.
  if (GetParam() == Format::csv) {
    const std::size_t end_of_header = text.find('\n');
    const auto header = csv_fields(text.substr(0, end_of_header));
    const std::size_t end_of_row = text.find('\n', end_of_header + 1);
    auto fields = csv_fields(text.substr(end_of_header + 1, end_of_row - end_of_header - 1));
    std::string row;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (header[i] == "ds402_statusword") fields[i] = "65536";
      row.append(i == 0 ? "" : ",").append(csv_field(fields[i]));
    }
    text.replace(end_of_header + 1, end_of_row - end_of_header - 1, row);
  } else {
    const std::size_t place = text.find(':', text.find("\"ds402_statusword\"")) + 1;
    text.replace(place, text.find(',', place) - place, "65536");
  }
  EXPECT_THAT(refusal_of(text),
              AllOf(HasSubstr("ds402_statusword is '65536'"), HasSubstr("from 0 to 65535")));
}

TEST_P(Text, WithoutContentIsRefused) {
  EXPECT_THAT(refusal_of(""), HasSubstr("the file is empty"));
}

INSTANTIATE_TEST_SUITE_P(Recording, Text, testing::Values(Format::csv, Format::json_lines),
                         [](const testing::TestParamInfo<Format>& tested) {
                           return tested.param == Format::csv ? "Csv" : "JsonLines";
                         });

std::string csv_refusal(const std::string& text) {
  try {
    (void)read_back(Format::csv, text);
  } catch (const RecordingError& error) {
    return error.what();
  }
  return "";
}

TEST(CsvRecording, WithAnUnknownColumnIsRefused) {
  EXPECT_THAT(csv_refusal(csv_header() + ",temperature\n"),
              AllOf(HasSubstr("line 1"), HasSubstr("no column 'temperature'")));
}

TEST(CsvRecording, WithoutAColumnIsRefused) {
  const std::string header = csv_header();
  EXPECT_THAT(csv_refusal(header.substr(0, header.find(",owner_epoch")) + "\n"),
              HasSubstr("lacks the column 'owner_epoch'"));
  EXPECT_THAT(csv_refusal(header + ",tick\n"), HasSubstr("two columns 'tick'"));
}

/// Removes the columns after the first 'owner_epoch' from each line.
std::string without_units(const std::string& text) {
  std::istringstream lines(text);
  std::string shorter;
  for (std::string line; std::getline(lines, line);) {
    for (int i = 0; i < 4; ++i) line.erase(line.rfind(','));
    shorter += line + "\n";
  }
  return shorter;
}

// 1000 UU are one millimetre.
TEST(CsvRecording, HasTheUnitOfEachAxisAndItsPositionAndVelocityInIt) {
  const auto benches = benches_of(1, 3);
  client::Observation sample = samples_of(benches[0], 1)[0];
  for (client::AxisSnapshot& axis : sample.axes) {
    axis.status.load_position_actual_value = -12'500;
    axis.status.load_velocity_actual_value = 2'048;
  }
  const std::string text = text_of(Format::csv, benches, {sample});
  EXPECT_THAT(text,
              AllOf(HasSubstr(",owner_epoch,unit,unit_size,position_in_unit,velocity_in_unit\n"),
                    HasSubstr(",mm,1000,-12.5,2.048\n"), HasSubstr(",deg,4096,-1098."),
                    HasSubstr(",,,,\n")));
  const Read read = read_back(Format::csv, text);
  ASSERT_EQ(read.contents.benches.size(), 1U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.contents.benches[0].axes[i].unit, benches[0].axes[i].unit);
  }
}

TEST(CsvRecording, OfAnOlderVersionHasNoUnits) {
  const auto benches = benches_of(1, 1);
  const std::string text = without_units(text_of(Format::csv, benches, samples_of(benches[0], 2)));
  const Read read = read_back(Format::csv, text);
  EXPECT_EQ(read.samples.size(), 2U);
  EXPECT_EQ(read.contents.benches.at(0).axes.at(0).unit, std::nullopt);
}

TEST(McapRecording, HasTheUnitOfEachAxis) {
  const auto benches = benches_of(1, 3);
  const Read read = read_back(Format::mcap, mcap_of(benches, samples_of(benches[0], 2)));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.contents.benches.at(0).axes.at(i).unit, benches[0].axes[i].unit);
  }
}

TEST(CsvRecording, WithBadCellsIsRefusedWithTheirNames) {
  const auto benches = benches_of(1, 1);
  const std::string text = text_of(Format::csv, benches, samples_of(benches[0], 1));
  std::string no_axis = text;
  no_axis.replace(text.find("\n1.1,") + 1, 3, "one");
  EXPECT_THAT(csv_refusal(no_axis), AllOf(HasSubstr("line 2"), HasSubstr("axis is 'one'")));
  std::string axis_0 = text;
  axis_0.replace(text.find("\n1.1,") + 1, 3, "1.0");
  EXPECT_THAT(csv_refusal(axis_0), HasSubstr("axis is '1.0'"));
  std::string no_tick = text;
  no_tick.replace(text.find(",1001,") + 1, 4, "-1");
  EXPECT_THAT(csv_refusal(no_tick), HasSubstr("tick is '-1'"));
}

TEST(JsonRecording, WithAnUnknownOrMissingFieldIsRefused) {
  const auto benches = benches_of(1, 1);
  std::string text = text_of(Format::json_lines, benches, samples_of(benches[0], 1));
  const auto refusal = [](const std::string& line) -> std::string {
    try {
      (void)read_back(Format::json_lines, line);
    } catch (const RecordingError& error) {
      return error.what();
    }
    return "";
  };
  std::string more = text;
  more.insert(1, "\"temperature\":3,");
  EXPECT_THAT(refusal(more), HasSubstr("no field 'temperature'"));
  std::string less = text;
  less.replace(less.find("\"owner_epoch\""), 13, "\"state\"");
  EXPECT_THAT(refusal(less), HasSubstr("lacks the field 'owner_epoch'"));
}

TEST(CsvFields, AreReadBackUnchanged) {
  EXPECT_THAT(csv_fields("a,\"b,\"\"c\"\"\",,d"), ElementsAre("a", "b,\"c\"", "", "d"));
  EXPECT_THAT(csv_fields(""), ElementsAre(""));
  EXPECT_THAT(csv_fields("a,"), ElementsAre("a", ""));
  EXPECT_THAT(csv_fields("\"open"), ElementsAre("open"));
}

/// A sample of one axis of a bench.
client::Observation seen(std::uint32_t bench, std::uint64_t tick, std::uint64_t missed = 0,
                         std::uint64_t skipped = 0) {
  client::Observation sample{.tick = tick, .missed = missed, .skipped = skipped, .axes = {}};
  sample.axes.emplace_back().id = {bench, 1};
  return sample;
}

TEST(GapLog, NamesGapsByTheTicksAroundThem) {
  GapLog log;
  log.note_sample(seen(1, 10));
  log.note_sample(seen(1, 14, 3));
  log.note_sample(seen(2, 20));
  log.note_sample(seen(1, 15));
  log.note_lost_end(1, 7);
  EXPECT_EQ(log.missed().total(), 10U);
  EXPECT_EQ(log.missed().text(4),
            "between the ticks 10 and 14 of bench 1 (3), after the tick 15 of bench 1 (7)");
  EXPECT_EQ(log.missed().text(1), "between the ticks 10 and 14 of bench 1 (3), and 1 further gap");
}

// The tick number jumped from 10 by 9,000 ticks, and two samples were lost in addition.
TEST(GapLog, CountsTheTicksOfAJumpApartFromLostSamples) {
  GapLog log;
  log.note_sample(seen(1, 10));
  log.note_sample(seen(1, 9'013, 2, 9'000));
  log.note_sample(seen(1, 9'014));
  EXPECT_EQ(log.missed().total(), 2U);
  EXPECT_EQ(log.jumps().total(), 9'000U);
  ASSERT_EQ(log.jumps().kept().size(), 1U);
  EXPECT_EQ(log.jumps().kept().front().after, 10U);
  EXPECT_EQ(log.jumps().kept().front().before, 9'013U);
  EXPECT_EQ(log.jumps().text(4), "between the ticks 10 and 9013 of bench 1 (9000)");
  for (std::uint64_t jump = 1; jump <= GapList::kKept; ++jump) {
    log.note_sample(seen(1, 9'014 + 10 * jump, 0, 9));
  }
  EXPECT_EQ(log.jumps().kept().size(), GapList::kKept);
  EXPECT_EQ(log.jumps().left_out(), 1U);
  EXPECT_EQ(log.jumps().total(), 18'000U);
}

TEST(GapLog, KeepsABoundedNumberOfGapsAndCountsTheOthers) {
  GapLog log;
  std::uint64_t tick = 0;
  for (std::size_t i = 0; i < GapList::kKept + 5; ++i) log.note_sample(seen(1, tick += 2, 1));
  EXPECT_EQ(log.missed().kept().size(), GapList::kKept);
  EXPECT_EQ(log.missed().left_out(), 5U);
  EXPECT_EQ(log.missed().total(), GapList::kKept + 5);
}

}  // namespace
}  // namespace vdrive::test
