// SPDX-License-Identifier: Apache-2.0
// `vdrive plot`: drawing recordings.
#include "convert.hpp"
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"
#include "tool/json_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

class Plot : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return directory_.path() / name; }

  /// @return a recording of `axes` axes of bench 1 named x1, x2, ... with a sample for each tick
  ///         from 100 on. The position of each axis is the tick times its number.
  [[nodiscard]] std::string recording_of(const std::string& name, std::uint16_t axes,
                                         std::uint64_t samples) const {
    const std::string file = path(name);
    const auto writer = recording::open_recording(file, "test");
    recording::RecordedBench bench{.number = 1};
    for (std::uint16_t axis = 1; axis <= axes; ++axis) {
      const std::string called = "x" + std::to_string(axis);
      bench.axes.push_back({.id = {1, axis}, .name = called, .topic = called});
    }
    writer->begin({bench});
    recording::Summary summary;
    for (std::uint64_t tick = 100; tick < 100 + samples; ++tick) {
      client::Observation sample;
      sample.tick = tick;
      for (std::uint16_t axis = 1; axis <= axes; ++axis) {
        client::AxisSnapshot& state = sample.axes.emplace_back();
        state.id = {1, axis};
        state.tick = tick;
        state.status.ds402_statusword = 0x0237;
        state.status.load_position_actual_value = static_cast<std::int32_t>(tick * axis);
      }
      writer->status(sample);
      ++summary.samples;
    }
    writer->finish(summary);
    return file;
  }

  static std::string text_in(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  /// Expects a call to draw nothing, with this exit code and message.
  void expect_refused(const std::string& words, int code, const std::string& message) const {
    const Finished finished = call("plot " + words);
    EXPECT_EQ(finished.code, code) << words;
    EXPECT_THAT(finished.errors, HasSubstr(message)) << words;
    EXPECT_THAT(finished.output, IsEmpty()) << words;
  }

 private:
  TemporaryDirectory directory_;
};

TEST_F(Plot, GivesTheSamePictureOfARecordingInEachFormat) {
  const std::string csv = recording_of("a.csv", 1, 50);
  const Finished drawn = call("plot " + csv + " -o " + path("csv.svg"));
  ASSERT_EQ(drawn.code, 0) << drawn.errors;
  EXPECT_THAT(drawn.errors, HasSubstr("drew 50 samples of 1.1 x1 to"));
  const std::string picture = text_in(path("csv.svg"));
  EXPECT_THAT(picture, AllOf(testing::StartsWith("<svg "), HasSubstr(">axis 1.1 x1<"),
                             HasSubstr(">50 samples from tick 100<")));
  for (const std::string format : {"jsonl", "mcap"}) {
    ASSERT_EQ(call("convert " + csv + " " + path("b." + format)).code, 0);
    ASSERT_EQ(call("plot " + path("b." + format) + " -o " + path(format + ".svg")).code, 0);
    EXPECT_EQ(text_in(path(format + ".svg")), picture) << format;
  }
}

TEST_F(Plot, WritesThePictureToStandardOutput) {
  const std::string csv = recording_of("a.csv", 1, 50);
  ASSERT_EQ(call("plot " + csv + " -o " + path("a.svg")).code, 0);
  EXPECT_EQ(call("plot " + csv + " -o -").output, text_in(path("a.svg")));
  EXPECT_EQ(call("plot " + csv + " -o - --json").output, text_in(path("a.svg")));
}

TEST_F(Plot, DrawsTheChosenAxisColumnsTimesAndSize) {
  const std::string csv = recording_of("a.csv", 2, 51);
  const Finished drawn = call("plot " + csv +
                              " --axis x2 --columns position,error_code --from 10ms "
                              "--to 20ms --width 500 --height 300 --json -o " +
                              path("a.svg"));
  ASSERT_EQ(drawn.code, 0) << drawn.errors;
  EXPECT_THAT(json_of(drawn),
              ElementsAre(Json{{"file", path("a.svg")},
                               {"axis", "1.2"},
                               {"name", "x2"},
                               {"from_tick", 110},
                               {"to_tick", 120},
                               {"samples", 11},
                               {"lost", 0},
                               {"faults", 0},
                               {"columns", Json{"load_position_actual_value", "error_code"}},
                               {"cut", nullptr}}));
  EXPECT_THAT(
      text_in(path("a.svg")),
      AllOf(HasSubstr("width=\"500\" height=\"300\""), HasSubstr(">position [UU]<"),
            HasSubstr(">error code<"), Not(HasSubstr("velocity")), HasSubstr("drive time [ms]")));
}

TEST_F(Plot, TakesThePeriodOfATextAndATitle) {
  const std::string csv = recording_of("a.csv", 1, 50);
  const Finished drawn =
      call({"plot", csv, "-o", path("a.svg"), "--period", "100ms", "--title", "a < b"});
  ASSERT_EQ(drawn.code, 0) << drawn.errors;
  EXPECT_THAT(text_in(path("a.svg")), AllOf(HasSubstr(">a &lt; b<"), HasSubstr("drive time [s]")));
}

TEST_F(Plot, OfAnAxisThatIsNotThereExitsThreeAndListsThePresentOnes) {
  const std::string csv = recording_of("a.csv", 2, 5);
  const std::string to = " -o " + path("a.svg");
  expect_refused(csv + to, 3, "has 2 axes; choose one with --axis: 1.1 x1, 1.2 x2");
  expect_refused(csv + to + " --axis lift", 3, "has no axis 'lift'; it has 1.1 x1, 1.2 x2");
  EXPECT_FALSE(std::filesystem::exists(path("a.svg")));
}

TEST_F(Plot, OfARecordingWithoutASampleFails) {
  const std::string empty = recording_of("empty.csv", 1, 0);
  const std::string to = " -o " + path("a.svg");
  expect_refused(empty + to, 1, "has no sample");
  expect_refused(path("none.csv") + to, 1, "No such file");
  expect_refused(recording_of("a.csv", 1, 5) + to + " --from 1s", 1,
                 "--from 1 s is after the end of");
  EXPECT_FALSE(std::filesystem::exists(path("a.svg")));
}

TEST_F(Plot, ThatCannotBeWrittenFailsWithTheReason) {
  const std::string csv = recording_of("a.csv", 1, 5);
  expect_refused(csv + " -o " + path("no/such/a.svg"), 1, "No such file");
  std::filesystem::create_symlink("/dev/full", path("full.svg"));
  expect_refused(csv + " -o " + path("full.svg"), 1, "No space left on device");
}

TEST_F(Plot, ExitsTwoOnAnArgumentThatIsNotValid) {
  const std::string csv = recording_of("a.csv", 1, 5);
  const std::string to = " -o " + path("a.svg");
  expect_refused(csv, 2, "--output");
  expect_refused(csv + " -o " + path("a.png"), 2, "does not end in .svg");
  expect_refused(csv + to + " --columns positon", 2, "no column 'positon'");
  expect_refused(csv + to + " --for 2s", 2, "--for is for recording an axis");
  expect_refused(csv + to + " --from 2s --to 1s", 2, "--from 2 s must be before --to 1 s");
  expect_refused(csv + to + " --width 10", 2, "320 to 4000 pixels");
  expect_refused(csv + to + " --height 200", 2, "too low for 4 panels");
  expect_refused(path("a.txt") + to, 2, "does not end in .csv, .jsonl or .mcap");
  expect_refused("1.1" + to, 2, "such as --for 2s");
  expect_refused("1.1 --for 1s --axis 1.2" + to, 2, "--axis is for a recording");
  EXPECT_FALSE(std::filesystem::exists(path("a.svg")));
}

TEST_F(Plot, OfAnAxisRecordsItFirst) {
  const BenchOnWire bench("--axes 1");
  const Finished drawn = call("plot 1.1 --for 50ms --json -o " + path("a.svg"));
  ASSERT_EQ(drawn.code, 0) << drawn.errors;
  const std::vector<Json> summary = json_of(drawn);
  ASSERT_THAT(summary, SizeIs(1));
  EXPECT_EQ(summary[0]["axis"], "1.1");
  // At most 50 ticks of 1 ms; some samples may be lost on a busy machine.
  const auto ticks =
      summary[0]["to_tick"].get<std::uint64_t>() - summary[0]["from_tick"].get<std::uint64_t>() + 1;
  EXPECT_LE(ticks, 50U);
  EXPECT_GE(summary[0]["samples"].get<std::uint64_t>(), 1U);
  EXPECT_LE(summary[0]["samples"].get<std::uint64_t>() + summary[0]["lost"].get<std::uint64_t>(),
            ticks);
  EXPECT_THAT(text_in(path("a.svg")),
              AllOf(HasSubstr(">Switch on disabled<"), HasSubstr(">position [deg]<"),
                    HasSubstr(">velocity [deg/s]<"), HasSubstr(">following error [deg]<")));
  EXPECT_EQ(call("plot 1.9 --for 50ms -o " + path("b.svg")).code, 3);
  EXPECT_FALSE(std::filesystem::exists(path("b.svg")));
}

}  // namespace
}  // namespace vdrive::test
