// SPDX-License-Identifier: Apache-2.0
// `vdrive record` to MCAP and `vdrive convert`.
#include "convert.hpp"
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"
#include "tool/json_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A bench, and a directory for recordings.
class McapRecordingOf {
 public:
  explicit McapRecordingOf(const std::string& words) : bench_(words) {}

  [[nodiscard]] std::string file(const std::string& name) const { return directory_.path() / name; }

 private:
  TemporaryDirectory directory_;
  BenchOnWire bench_;
};

TEST(McapRecording, FailsWithAReasonOnAFullDiskOrAnUnusablePath) {
  const McapRecordingOf bench("--axes 1");
  const std::string full = bench.file("full.mcap");
  std::filesystem::create_symlink("/dev/full", full);
  const Finished finished = call("record " + full + " --for 3600s");
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("full.mcap"), HasSubstr("No space left on device"),
                                     Not(HasSubstr("recorded"))));
  const Finished wrong = call("record " + bench.file("no/such/run.mcap"));
  EXPECT_EQ(wrong.code, 1);
  EXPECT_THAT(wrong.errors, HasSubstr("No such file"));
}

TEST(McapRecording, EndsAfterTheGivenNumberOfSamplesWithItsSummary) {
  const McapRecordingOf bench("--axes 20");
  const std::string mcap = bench.file("run.mcap");
  const Finished finished = call("record " + mcap + " --count 50 --json");
  ASSERT_EQ(finished.code, 0) << finished.errors;
  const Json summary = Json::parse(finished.output);
  EXPECT_EQ(summary["samples"], 50);
  std::uint64_t lost = 0;
  std::uint64_t last = 0;
  const auto contents = recording::read_recording(mcap, [&](const client::Observation& sample) {
    EXPECT_EQ(sample.axes.size(), 20U);
    if (last != 0) {
      EXPECT_EQ(sample.tick - last, 1 + sample.missed);
    }
    last = sample.tick;
    lost += sample.missed;
  });
  EXPECT_THAT(contents.cut, IsEmpty());
  EXPECT_EQ(contents.samples, 50U);
  EXPECT_EQ(contents.parameters, 20U);
  EXPECT_EQ(summary["lost"], lost);
  std::uint64_t in_gaps = 0;
  for (const Json& gap : summary["gaps"]) in_gaps += gap["missed"].get<std::uint64_t>();
  EXPECT_EQ(in_gaps, lost);
}

TEST(Convert, NeedsNoServiceAndNamesFileAndLine) {
  const TemporaryDirectory directory;
  const std::string csv = directory.path() / "a.csv";
  const std::string mcap = directory.path() / "a.mcap";
  std::ofstream(csv) << "axis,name,temperature\n";
  const Finished unknown = call("convert " + csv + " " + mcap);
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.errors,
              AllOf(HasSubstr("a.csv"), HasSubstr("line 1"), HasSubstr("no column 'temperature'")));
  EXPECT_FALSE(std::filesystem::exists(mcap));
  EXPECT_EQ(call("convert " + csv + " " + csv).code, 2);
  std::ofstream(mcap) << "no such thing";
  const Finished foreign = call("convert " + mcap + " " + csv);
  EXPECT_EQ(foreign.code, 1);
  EXPECT_THAT(foreign.errors, AllOf(HasSubstr("a.mcap"), HasSubstr("not an MCAP file")));
}

}  // namespace
}  // namespace vdrive::test
