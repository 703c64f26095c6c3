// SPDX-License-Identifier: Apache-2.0
// Conversion from one recording format to another.
#include "convert.hpp"

#include "recording/sample_recording.hpp"
#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace vdrive::test {
namespace {

using namespace recording;
using testing::AllOf;
using testing::HasSubstr;

class Convert : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return directory_.path() / name; }

  void put(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }

  [[nodiscard]] std::string bytes_of(const std::string& name) const {
    std::ifstream stream(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  Contents make(const std::string& from, const std::string& to,
                std::optional<std::chrono::nanoseconds> period = {}) const {
    return convert({.from = path(from), .to = path(to), .period = period, .version = "test"});
  }

  [[nodiscard]] std::string refusal_of(const std::string& from, const std::string& to) const {
    try {
      (void)make(from, to);
    } catch (const RecordingError& error) {
      return error.what();
    }
    return "";
  }

  const std::vector<RecordedBench> benches_ = benches_of(1, 3);
  const std::vector<client::Observation> samples_ = samples_of(benches_[0], 25);

 private:
  TemporaryDirectory directory_;
};

TEST_F(Convert, ThroughEveryFormatGivesTheOriginalText) {
  const std::string csv = text_of(Format::csv, benches_, samples_);
  put("a.csv", csv);
  make("a.csv", "b.mcap");
  make("b.mcap", "c.jsonl");
  make("c.jsonl", "d.mcap");
  make("d.mcap", "e.csv");
  EXPECT_EQ(bytes_of("e.csv"), csv);
  EXPECT_EQ(bytes_of("c.jsonl"), text_of(Format::json_lines, benches_, samples_));
}

TEST_F(Convert, OfAnMcapGivesTheTextThatARecorderWrites) {
  const client::Event event{.bench = 1, .axis = 1, .tick = 1001, .text = "fault"};
  put("a.mcap", mcap_of(benches_, samples_, {event}));
  const Contents contents = make("a.mcap", "b.csv");
  EXPECT_EQ(bytes_of("b.csv"), text_of(Format::csv, benches_, samples_));
  EXPECT_EQ(contents.samples, 25U);
  EXPECT_EQ(contents.rows, 75U);
  EXPECT_EQ(contents.events, 1U);
}

TEST_F(Convert, OfATextUsesTheGivenPeriod) {
  put("a.csv", text_of(Format::csv, benches_, samples_));
  make("a.csv", "b.mcap", std::chrono::microseconds(250));
  const Contents read = read_recording(path("b.mcap"), [](const client::Observation&) {});
  EXPECT_EQ(read.benches.at(0).period, std::chrono::microseconds(250));
  make("a.csv", "c.mcap");
  const Contents other = read_recording(path("c.mcap"), [](const client::Observation&) {});
  EXPECT_EQ(other.benches.at(0).period, std::chrono::milliseconds(1));
}

TEST_F(Convert, OfAnIncompleteMcapGivesItsContentAndReportsIt) {
  const std::string whole = mcap_of(benches_, samples_);
  // Only the summary is cut off; all messages are still there.
  put("a.mcap", whole.substr(0, whole.size() - 100));
  const Contents contents = make("a.mcap", "b.csv");
  EXPECT_THAT(contents.cut, HasSubstr("at byte " + std::to_string(whole.size() - 100)));
  EXPECT_EQ(bytes_of("b.csv"), text_of(Format::csv, benches_, samples_));
}

TEST_F(Convert, WithAnErrorInItsInputLeavesTheOutputUnchanged) {
  const std::string csv = text_of(Format::csv, benches_, samples_);
  put("torn.csv", csv.substr(0, csv.size() - 1));
  put("there.mcap", "something of somebody");
  EXPECT_THAT(refusal_of("torn.csv", "there.mcap"),
              AllOf(HasSubstr("torn.csv"), HasSubstr("line 76"),
                    HasSubstr("the last line has no line break")));
  EXPECT_EQ(bytes_of("there.mcap"), "something of somebody");
}

TEST_F(Convert, RefusesUnusableFileNamesAndFiles) {
  put("a.csv", text_of(Format::csv, benches_, samples_));
  std::filesystem::create_symlink(path("a.csv"), path("b.jsonl"));
  EXPECT_THAT(refusal_of("a.csv", "b.jsonl"), HasSubstr("are the same file"));
  EXPECT_THAT(refusal_of("a.csv", "b.txt"), HasSubstr("does not end in"));
  EXPECT_THAT(refusal_of("none.csv", "b.mcap"), HasSubstr("No such file"));
  std::filesystem::create_directory(path("folder.csv"));
  EXPECT_THAT(refusal_of("folder.csv", "b.mcap"), HasSubstr("it is not a regular file"));
  EXPECT_THAT(refusal_of("a.csv", "no/such/x.mcap"), HasSubstr("No such file"));
  std::filesystem::create_symlink("/dev/full", path("full.mcap"));
  EXPECT_THAT(refusal_of("a.csv", "full.mcap"), HasSubstr("No space left on device"));
}

TEST_F(Convert, NamesOnlyTheFileThatCannotBeWritten) {
  // For both formats: one file is written while the other is read.
  const auto samples = samples_of(benches_[0], 2'000);
  put("a.csv", text_of(Format::csv, benches_, samples));
  put("a.mcap", mcap_of(benches_, samples));
  for (const std::string from : {"a.csv", "a.mcap"}) {
    for (const std::string to : {"full.jsonl", "full.mcap"}) {
      std::error_code there;
      std::filesystem::create_symlink("/dev/full", path(to), there);
      EXPECT_EQ(refusal_of(from, to), "cannot write '" + path(to) + "': No space left on device");
    }
  }
}

}  // namespace
}  // namespace vdrive::test
