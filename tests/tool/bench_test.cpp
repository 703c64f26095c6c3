// SPDX-License-Identifier: Apache-2.0
// `vdrive test` and `vdrive bench`: private benches, one report, nothing left behind.
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

using Json = nlohmann::ordered_json;

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// @return whether a process has `text` in its environment.
bool is_anywhere(const std::string& text) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    if (content_of(entry.path() / "environ").find(text) != std::string::npos) return true;
  }
  return false;
}

/// A call of the tool with its own files. Its processes are found by a variable of their
/// environment.
class PrivateBenches : public testing::Test {
 protected:
  PrivateBenches() {
    setenv("VDRIVE_TEST_MARK", mark_.c_str(), 1);  // NOLINT(concurrency-mt-unsafe): one thread
  }

  ~PrivateBenches() override {
    unsetenv("VDRIVE_TEST_MARK");  // NOLINT(concurrency-mt-unsafe): one thread
  }

  std::string file(const std::string& name, const std::string& lines) {
    const std::string path = directory_.path() / name;
    std::ofstream(path) << lines;
    return path;
  }

  [[nodiscard]] std::string report() const { return directory_.path() / "out.xml"; }

  [[nodiscard]] static Process start(std::vector<std::string> arguments,
                                     const std::string& command = "test") {
    arguments.insert(arguments.begin(), command);
    return {VDRIVE_TOOL, std::move(arguments)};
  }

  static Finished run(std::vector<std::string> arguments) {
    return start(std::move(arguments)).wait();
  }

  /// @return whether every process of the call ends within some time.
  [[nodiscard]] bool all_have_ended() const {
    const auto deadline = std::chrono::steady_clock::now() + 30s;
    while (is_anywhere(mark_)) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::yield();
    }
    return true;
  }

  [[nodiscard]] bool some_run() const { return is_anywhere(mark_); }

  const std::string mark_ = "vdrive-mark-" + std::to_string(test_domain());
  TemporaryDirectory directory_;
};

TEST_F(PrivateBenches, RunEachFileOnANewBenchAndWriteOneReport) {
  const std::string same = "expect 1.1 position 0\nenable 1.1\nmove 1.1 500\n";
  const Finished finished =
      run({file("a.scn", same), file("b.scn", same + "expect 1.1 position < 100\n"),
           file("c.scn", same), "--jobs", "2", "--junit", report()});
  EXPECT_EQ(finished.code, 1) << finished.output;
  EXPECT_THAT(finished.output, AllOf(HasSubstr("passed  "), HasSubstr("2 of 3 files passed")));
  EXPECT_THAT(finished.errors, HasSubstr("b.scn:4: "));
  const std::string xml = content_of(report());
  EXPECT_THAT(xml, AllOf(HasSubstr("<testsuites tests=\"10\" failures=\"1\""),
                         HasSubstr("a.scn\" tests=\"3\" failures=\"0\""),
                         HasSubstr("b.scn\" tests=\"4\" failures=\"1\""),
                         HasSubstr("line 4: expect 1.1 position &lt; 100")));
  EXPECT_TRUE(all_have_ended());
}

TEST_F(PrivateBenches, HaveTheAxesOfTheConfiguration) {
  const std::string configuration =
      file("bench.yaml", "clock: {mode: realtime}\naxes:\n  - {number: 3, name: lift}\n");
  const Finished finished = run({file("a.scn", "let axis = nobody\nenable ${axis}\nstep 10\n"),
                                 "--config", configuration, "--set", "axis=lift", "--json"});
  EXPECT_EQ(finished.code, 0) << finished.errors;
  ASSERT_THAT(finished.lines(), SizeIs(2));
  EXPECT_EQ(Json::parse(finished.lines()[0])["passed"], true);
  EXPECT_EQ(Json::parse(finished.lines()[1])["files"], 1);
}

TEST_F(PrivateBenches, DoNotStartAfterAUsageError) {
  const std::string good = file("a.scn", "enable 1.1\n");
  const Finished mistake = run({good, file("b.scn", "enabel 1.1\n"), "--junit", report()});
  EXPECT_EQ(mistake.code, 2);
  EXPECT_THAT(mistake.errors, HasSubstr("b.scn:1: 'enabel' is not a command"));
  EXPECT_THAT(content_of(report()), HasSubstr("errors=\"1\""));
  EXPECT_EQ(run({good, "--service", "/nonexistent"}).code, 2);
  EXPECT_EQ(run({good, "--jobs", "0"}).code, 2);
  EXPECT_EQ(run({"-"}).code, 2);
  const Finished configuration = run({good, "--config", file("bad.yaml", "axis: 5\n")});
  EXPECT_EQ(configuration.code, 2);
  EXPECT_THAT(configuration.errors, HasSubstr("bad.yaml"));
}

TEST_F(PrivateBenches, NameAMissingAxis) {
  const Finished finished = run({file("a.scn", "enable 1.9\n"), "--timeout", "1"});
  EXPECT_EQ(finished.code, 3);
  EXPECT_THAT(finished.errors, HasSubstr("a.scn:1: "));
}

TEST_F(PrivateBenches, MeasureTheCapacityOfTheMachine) {
  const Finished finished = start({"--quick", "--json"}, "bench").wait();
  ASSERT_EQ(finished.code, 0) << finished.errors;
  ASSERT_THAT(finished.lines(), SizeIs(1));
  const Json figures = Json::parse(finished.lines()[0]);
  // A second has 1,000 ticks; a busy machine makes fewer, and all of them late.
  EXPECT_GT(figures["lateness_of_ticks"]["max_us"], 0.0);
  EXPECT_GT(figures["lateness_of_a_bare_loop"]["max_us"], 0.0);
  EXPECT_GT(figures["steps"]["per_second"], 10.0);
  // No processor steps an axis in less than 1 ns, and no machine needs 1 ms.
  EXPECT_GT(figures["tick_of_an_axis_ns"], 1.0);
  EXPECT_LT(figures["tick_of_an_axis_ns"], 1.0e6);
  EXPECT_EQ(figures["status"][0]["axes"], 64);
  EXPECT_GT(figures["status"][0]["samples"], 0);
  EXPECT_TRUE(all_have_ended());
}

TEST_F(PrivateBenches, AreNotMeasuredWithoutAService) {
  const Finished finished = start({"--service", "/nonexistent"}, "bench").wait();
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors, HasSubstr("/nonexistent"));
}

// Its drive time is long: it runs until it is ended.
constexpr const char* kLong =
    "enable 1.1\nmove 1.1 1000000 --velocity 1 --timeout 3600000\nfinally\ndisable 1.1\n";

/// Ends a call by a signal once its scenario runs.
class EndedBy : public PrivateBenches, public testing::WithParamInterface<int> {
 protected:
  [[nodiscard]] bool scenario_runs() const {
    return comes_true([this] {
      return runs("a.scn", "--json");
    });
  }

  /// @return whether a process of ours has both in its command line.
  [[nodiscard]] bool runs(const std::string& first, const std::string& second) const {
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      if (content_of(entry.path() / "environ").find(mark_) == std::string::npos) continue;
      const std::string line = content_of(entry.path() / "cmdline");
      if (line.find(first) != std::string::npos && line.find(second) != std::string::npos) {
        return true;
      }
    }
    return false;
  }

  template <typename Condition>
  static bool comes_true(const Condition& condition) {
    const auto deadline = std::chrono::steady_clock::now() + 60s;
    while (std::chrono::steady_clock::now() < deadline) {
      if (condition()) return true;
    }
    return false;
  }
};

TEST_P(EndedBy, ASignalATestRunLeavesNoProcessBehind) {
  Process test = start({file("a.scn", kLong), file("b.scn", kLong), "--junit", report()});
  ASSERT_TRUE(scenario_runs());
  EXPECT_TRUE(some_run());
  test.send(GetParam());
  const Finished finished = test.wait();
  EXPECT_EQ(finished.code, GetParam() == SIGKILL ? -SIGKILL : 130);
  EXPECT_TRUE(all_have_ended());
  if (GetParam() != SIGKILL) {
    EXPECT_THAT(content_of(report()), HasSubstr("<testsuites"));
  }
}

TEST_P(EndedBy, ASignalAMeasurementLeavesNoProcessBehind) {
  Process bench = start({}, "bench");
  ASSERT_TRUE(comes_true([this] {
    return runs("vdrived", "--axes");
  }));
  bench.send(GetParam());
  EXPECT_EQ(bench.wait().code, GetParam() == SIGKILL ? -SIGKILL : 130);
  EXPECT_TRUE(all_have_ended());
}

INSTANTIATE_TEST_SUITE_P(Signals, EndedBy, testing::Values(SIGINT, SIGTERM, SIGKILL));

}  // namespace
}  // namespace vdrive::test
