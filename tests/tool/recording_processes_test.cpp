// SPDX-License-Identifier: Apache-2.0
// `vdrive record` together with other programs, and of services that end, freeze or stand still.
#include "convert.hpp"
#include "support/temporary_directory.hpp"
#include "tool/json_lines.hpp"
#include "tool/process.hpp"
#include "tool/pseudo_terminal.hpp"
#include "tool/screen.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <sstream>
#include <thread>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr std::chrono::seconds kDeadline{60};

/// A service, and a directory for recordings.
class McapRecordingOf {
 public:
  explicit McapRecordingOf(const std::string& words) : service_(words) {}

  [[nodiscard]] std::string file(const std::string& name) const { return directory_.path() / name; }

 private:
  TemporaryDirectory directory_;
  RunningService service_;
};

/// @return the tool's output on a terminal until it ended, on its own or by Ctrl-C (code 130).
std::string shown_of(const std::string& words, const std::string& awaited, int code) {
  PseudoTerminal terminal(24, 100, words);
  static_cast<void>(terminal.wait_until([&](const Screen& /*screen*/) {
    return terminal.output().find(awaited) != std::string::npos;
  }));
  if (code == 130) terminal.interrupt();
  EXPECT_EQ(terminal.wait(), code) << terminal.output();
  return terminal.output();
}

TEST(RecordOnATerminal, SaysHowARecordingWithoutAnEndIsEnded) {
  const McapRecordingOf bench("--clock realtime");
  const std::string hint = "vdrive: recording; Ctrl-C ends it";
  const std::string record = "record " + bench.file("a.csv") + " 1.1";
  EXPECT_THAT(shown_of(record, hint, 130), AllOf(HasSubstr(hint), HasSubstr("recorded ")));
  EXPECT_THAT(shown_of(record + " --count 5", "recorded 5 samples", 0), Not(HasSubstr(hint)));
  EXPECT_THAT(shown_of(record + " --for 5ms", "recorded ", 0), Not(HasSubstr(hint)));
}

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

/// The rows of a CSV recording by axis and tick, without their column "missed".
std::map<std::string, std::string> rows_of(const std::string& path) {
  std::map<std::string, std::string> rows;
  const auto lines = lines_of(path);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    std::istringstream text(lines[i]);
    std::string axis;
    std::string name;
    std::string tick;
    std::string missed;
    std::string values;
    std::getline(text, axis, ',');
    std::getline(text, name, ',');
    std::getline(text, tick, ',');
    std::getline(text, missed, ',');
    std::getline(text, values);
    rows[axis.append(" ").append(tick)] = name.append(",").append(values);
  }
  return rows;
}

/// Steps until both files have data, that is, until their recorders receive the stream.
void step_until_written(const std::vector<std::string>& files) {
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  for (const std::string& file : files) {
    while (!std::filesystem::exists(file) || std::filesystem::file_size(file) == 0) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << file;
      ASSERT_EQ(tool("step 1").code, 0);
    }
  }
}

std::size_t samples_in(const std::string& path) {
  std::size_t samples = 0;
  (void)recording::read_recording(path, [&](const client::Observation&) {
    ++samples;
  });
  return samples;
}

TEST(McapRecording, HasTheValuesOfTheCsvOfTheSameRun) {
  const McapRecordingOf bench("--clock lockstep --axes 2");
  const std::string csv = bench.file("run.csv");
  const std::string mcap = bench.file("run.mcap");
  Process text(VDRIVE_TOOL, tool_arguments("record " + csv));
  Process recorder(VDRIVE_TOOL, tool_arguments("record " + mcap + " --json"));
  step_until_written({csv, mcap});
  ASSERT_EQ(tool("enable 1.1").code, 0);
  ASSERT_EQ(tool("move 1.1 200 --no-wait").code, 0);
  for (int i = 0; i < 20; ++i) ASSERT_EQ(tool("step 20").code, 0);
  for (Process* process : {&text, &recorder}) process->send(SIGINT);
  EXPECT_EQ(text.wait().code, 130);
  const Finished finished = recorder.wait();
  EXPECT_EQ(finished.code, 130);
  const Json summary = Json::parse(finished.output);
  EXPECT_GT(summary["events"], 0);

  const std::string back = bench.file("back.csv");
  const Finished converted = tool("convert " + mcap + " " + back + " --json");
  ASSERT_EQ(converted.code, 0) << converted.errors;
  const Json contents = Json::parse(converted.output);
  EXPECT_EQ(contents["samples"], summary["samples"]);
  EXPECT_EQ(contents["rows"], 2 * summary["samples"].get<std::uint64_t>());
  EXPECT_EQ(contents["events_left_out"], summary["events"]);
  EXPECT_EQ(contents["parameters_left_out"], 2);
  EXPECT_TRUE(contents["cut"].is_null());
  // The stream is best effort: a recorder may lose samples, and reports it.
  const auto direct = rows_of(csv);
  const auto through = rows_of(back);
  std::size_t common = 0;
  for (const auto& [key, values] : through) {
    const auto other = direct.find(key);
    if (other == direct.end()) continue;
    EXPECT_EQ(values, other->second) << key;
    ++common;
  }
  EXPECT_GE(common, 400U) << "of 2 axes in some 440 ticks";
  EXPECT_EQ(lines_of(back).front(), lines_of(csv).front());

  // A round trip of conversions does not change the text.
  const std::string again = bench.file("again.mcap");
  const std::string last = bench.file("last.csv");
  ASSERT_EQ(tool("convert " + csv + " " + again).code, 0);
  ASSERT_EQ(tool("convert " + again + " " + last).code, 0);
  EXPECT_EQ(lines_of(last), lines_of(csv));
}

TEST(McapRecording, OfAKilledRecorderIsReadableUpToItsEnd) {
  const McapRecordingOf bench("--axes 2");
  const std::string mcap = bench.file("run.mcap");
  Process recorder(VDRIVE_TOOL, tool_arguments("record " + mcap));
  // The recorder writes its samples to the file within a second.
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  const auto has_samples = [&] {
    return std::filesystem::exists(mcap) && std::filesystem::file_size(mcap) != 0 &&
           samples_in(mcap) != 0;
  };
  while (!has_samples() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  recorder.send(SIGKILL);
  EXPECT_EQ(recorder.wait().code, -SIGKILL);
  const std::string csv = bench.file("run.csv");
  const Finished converted = tool("convert " + mcap + " " + csv);
  EXPECT_EQ(converted.code, 0) << converted.errors;
  EXPECT_THAT(converted.errors, AllOf(HasSubstr("is incomplete"), HasSubstr("at byte ")));
  const std::size_t samples = samples_in(mcap);
  EXPECT_GT(samples, 0U);
  EXPECT_EQ(lines_of(csv).size(), 1 + 2 * samples);
}

// ---- a bench that sends nothing ----------------------------------------------------------------

/// Reads the errors of a recorder up to a line that contains `part`.
/// @return that line; if there is none, all lines.
std::string awaited_line(Process& recorder, const std::string& part) {
  std::string others;
  std::string line = recorder.read_error_line();
  while (!line.empty() && line.find(part) == std::string::npos) {
    others += line + "\n";
    line = recorder.read_error_line();
  }
  return line.empty() ? others : line;
}

TEST(Recorder, WaitsForABenchWhoseTimeStandsStill) {
  const McapRecordingOf bench("--clock lockstep --axes 1");
  const std::string file = bench.file("still.csv");
  Process recorder(VDRIVE_TOOL, tool_arguments("record " + file + " --count 5 --lost-after 1s"));
  step_until_written({file});
  // Three seconds of wall-clock time pass without a step, while a search for another bench times
  // out.
  EXPECT_EQ(tool("status 9.1 --timeout 3").code, 3);
  for (int i = 0; i < 5; ++i) ASSERT_EQ(tool("step 1").code, 0);
  const Finished finished = recorder.wait();
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.errors, Not(HasSubstr("sends nothing")));
  EXPECT_EQ(samples_in(file), 5U);
}

TEST(Recorder, WaitsForASilentBenchAndCountsMissingSamples) {
  const RunningService service("--clock lockstep --axes 1");
  const TemporaryDirectory directory;
  const std::string file = directory.path() / "frozen.csv";
  Process recorder(VDRIVE_TOOL, tool_arguments("record " + file));
  step_until_written({file});
  service.freeze();
  EXPECT_THAT(awaited_line(recorder, "sends nothing"),
              HasSubstr("bench 1 sends nothing: waiting 60 s for it"));
  service.thaw();
  // The tool can step the service only once it runs again; the recorder then reports a sample.
  ASSERT_EQ(tool("step 3 --timeout 20").code, 0);
  EXPECT_THAT(awaited_line(recorder, "sends again"), HasSubstr("bench 1 sends again"));
  recorder.send(SIGINT);
  const Finished finished = recorder.wait();
  EXPECT_EQ(finished.code, 130) << finished.errors;
}

/// @return the ticks of the complete rows of a CSV recording in progress.
std::vector<std::uint64_t> ticks_in(const std::string& csv) {
  std::ifstream file(csv);
  std::vector<std::uint64_t> ticks;
  std::string row;
  std::getline(file, row);  // the column names
  // A row without a line feed is incomplete, in which case eof() is true.
  while (std::getline(file, row) && !file.eof()) {
    std::istringstream cells(row);
    std::string cell;
    for (int column = 0; column < 3; ++column) std::getline(cells, cell, ',');
    ticks.push_back(std::stoull(cell));
  }
  return ticks;
}

/// Waits until the recording has more than `rows` rows, while another program searches for benches.
/// @return their ticks.
std::vector<std::uint64_t> wait_for_rows(const std::string& csv, std::size_t rows) {
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  auto ticks = ticks_in(csv);
  while (ticks.size() <= rows && std::chrono::steady_clock::now() < end) {
    EXPECT_EQ(tool("list").code, 0);
    ticks = ticks_in(csv);
  }
  EXPECT_GT(ticks.size(), rows);
  return ticks;
}

/// Freezes the service until the recorder reports its silence, and for at least 1.5 s, because on a
/// busy machine the recorder may have reported a silence before. Afterwards the tick number jumps
/// over that time. The recording must not end earlier: with seven other tests running, a search
/// takes up to a second.
void let_the_tick_jump(const RunningService& service, Process& recorder, const std::string& file) {
  // Without a sample, a recorder fails instead of waiting for the bench.
  ASSERT_FALSE(wait_for_rows(file, 0).empty());
  service.freeze();
  const auto frozen = std::chrono::steady_clock::now();
  EXPECT_THAT(awaited_line(recorder, "sends nothing"), HasSubstr("bench 1 sends nothing"));
  while (std::chrono::steady_clock::now() < frozen + std::chrono::milliseconds(1500))
    (void)tool("list --timeout 0.2");
  service.thaw();
}

// The service is frozen for 1.5 s of these 3 s, so the recorder continues for 1.5 s longer.
TEST(Recorder, LastsItsDriveTimeAcrossAJumpOfTheTickNumberAndNamesIt) {
  const RunningService service("--axes 1");
  const TemporaryDirectory directory;
  const std::string file = directory.path() / "jump.csv";
  Process recorder(VDRIVE_TOOL, tool_arguments("record " + file + " --for 3s --json"));
  let_the_tick_jump(service, recorder, file);
  const Finished finished = recorder.wait();
  ASSERT_EQ(finished.code, 0) << finished.errors;
  const Json summary = Json::parse(finished.lines().back());
  EXPECT_GE(summary["skipped"], 1'000) << finished.output;
  // Samples lost at the very end are not counted.
  EXPECT_GE(summary["samples"].get<int>() + summary["lost"].get<int>(), 2'900) << finished.output;
  EXPECT_LE(summary["samples"].get<int>() + summary["lost"].get<int>(), 3'001) << finished.output;
  ASSERT_FALSE(summary["jumps"].empty());
  const Json& jump = summary["jumps"].front();
  EXPECT_EQ(jump["bench"], 1);
  EXPECT_GT(jump["before"], jump["after"]);
  EXPECT_GE(jump["skipped"], 100);
  EXPECT_EQ(summary["jumps_left_out"], 0);
}

// Samples that arrive after the pause may have been sent before the jump. The recording therefore
// continues until it has one from after the jump; it has no --for that might end it earlier.
TEST(Recorder, SaysInItsLastLineWhatAJumpSkipped) {
  const RunningService service("--axes 1");
  const TemporaryDirectory directory;
  const std::string file = directory.path() / "jump.csv";
  Process recorder(VDRIVE_TOOL, tool_arguments("record " + file));
  let_the_tick_jump(service, recorder, file);
  EXPECT_THAT(awaited_line(recorder, "sends again"), HasSubstr("bench 1 sends again"));
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  auto ticks = ticks_in(file);
  // The service was frozen for 1.5 s; a tick takes 1 ms.
  while (ticks.back() - ticks.front() < ticks.size() + 1'000) {
    ASSERT_LT(std::chrono::steady_clock::now(), end);
    ticks = wait_for_rows(file, ticks.size());
  }
  recorder.send(SIGINT);
  const Finished finished = recorder.wait();
  EXPECT_THAT(finished.errors,
              HasSubstr("ticks skipped by a jump of the tick number between the ticks "))
      << "exit code " << finished.code << ", output: " << finished.output;
}

TEST(Recorder, EndsWhenABenchHasSentNothingForTooLong) {
  RunningService service("--axes 1");
  const TemporaryDirectory directory;
  const std::string file = directory.path() / "killed.csv";
  Process recorder(VDRIVE_TOOL, tool_arguments("record " + file + " --lost-after 500ms"));
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  while (!std::filesystem::exists(file) || std::filesystem::file_size(file) == 0) {
    ASSERT_LT(std::chrono::steady_clock::now(), end);
    ASSERT_EQ(tool("list").code, 0);
  }
  service.kill();
  const Finished finished = recorder.wait();
  EXPECT_EQ(finished.code, 1) << finished.errors;
  EXPECT_THAT(finished.errors, HasSubstr("bench 1 sends nothing: waiting 0.5 s for it"));
  EXPECT_THAT(finished.errors, HasSubstr("the recording ends: bench 1 has sent nothing for 0.5 s"));
  EXPECT_THAT(finished.errors, HasSubstr("recorded "));
}

TEST(Recorder, EndsAtOnceWhenTheServiceEndsOrRestarts) {
  auto service = std::make_unique<RunningService>("--clock lockstep --axes 1");
  const TemporaryDirectory directory;
  const auto record = [&](const std::string& name) {
    const std::string file = directory.path() / name;
    auto recorder = std::make_unique<Process>(VDRIVE_TOOL, tool_arguments("record " + file));
    step_until_written({file});
    return recorder;
  };
  auto recorder = record("ended.csv");
  (void)service->stop();
  Finished finished = recorder->wait();
  EXPECT_EQ(finished.code, 1) << finished.errors;
  EXPECT_THAT(finished.errors, HasSubstr("the recording ends: bench 1"));
  service = std::make_unique<RunningService>("--clock lockstep --axes 1");
  recorder = record("restarted.csv");
  service->kill();
  service = std::make_unique<RunningService>("--clock lockstep --axes 1");
  finished = recorder->wait();
  EXPECT_EQ(finished.code, 1) << finished.errors;
  EXPECT_THAT(finished.errors, HasSubstr("the recording ends: bench 1"));
}

}  // namespace
}  // namespace vdrive::test
