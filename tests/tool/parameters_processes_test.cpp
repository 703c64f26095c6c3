// SPDX-License-Identifier: Apache-2.0
// Stored parameters of a service: across kills and restarts, in a journal, and with two services.
#include "support/effort.hpp"
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace vdrive::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kRead = "read 1.1 profile_velocity";

class StoredParameters : public testing::Test {
 protected:
  [[nodiscard]] std::string flags(const std::string& clock) const {
    return "--clock " + clock + " --state " + directory.path().string();
  }

  [[nodiscard]] fs::path file(const std::string& suffix = "") const {
    return directory.path() / ("bench-1.parameters" + suffix);
  }

  /// @return the write times of the file and of the `.new` file that will replace it.
  [[nodiscard]] std::array<fs::file_time_type, 2> stamps() const {
    std::error_code none;
    return {fs::last_write_time(file(), none), fs::last_write_time(file(".new"), none)};
  }

  static void expect_done(const std::string& words) {
    const Finished finished = tool(words);
    EXPECT_EQ(finished.code, 0) << words << ": " << finished.errors;
  }

  TemporaryDirectory directory;
};

class StoredParametersOfAClock : public StoredParameters,
                                 public testing::WithParamInterface<std::string> {};

TEST_P(StoredParametersOfAClock, ReturnAfterAKillOfTheServiceUntilTheyAreRestored) {
  {
    RunningService service(flags(GetParam()));
    expect_done("write 1.1 profile_velocity 4321");
    expect_done("store 1.1");
    expect_done("write 1.1 profile_velocity 9");
    service.kill();
  }
  {
    RunningService service(flags(GetParam()));
    EXPECT_THAT(tool(kRead).output, HasSubstr("4321"));
    expect_done("restore 1.1");
    EXPECT_THAT(tool(kRead).output, HasSubstr("4321")) << "until the next power cycle";
    expect_done("power-cycle 1.1");
    EXPECT_THAT(tool(kRead).output, HasSubstr("68267"));
    service.kill();
  }
  const RunningService service(flags(GetParam()));
  EXPECT_THAT(tool(kRead).output, HasSubstr("68267"));
}

INSTANTIATE_TEST_SUITE_P(Clocks, StoredParametersOfAClock,
                         testing::Values("realtime", "lockstep", "freerun"), [](const auto& clock) {
                           return clock.param;
                         });

TEST_F(StoredParameters, BelongToOneService) {
  const RunningService service(flags("lockstep"));
  const Finished second =
      Process(VDRIVE_SERVICE, {"--state", directory.path().string(), "--domain",
                               std::to_string(test_domain()), "--log-level", "off"})
          .wait();
  EXPECT_EQ(second.code, 1);
  EXPECT_THAT(second.errors,
              testing::AllOf(HasSubstr("the parameters of bench 1 are in use by process "),
                             HasSubstr("process " + std::to_string(service.id()) +
                                       " (vdrived) on this host")));
  const Finished nowhere = Process(VDRIVE_SERVICE, {"--state", "/nonexistent/state"}).wait();
  EXPECT_EQ(nowhere.code, 1);
  EXPECT_THAT(nowhere.errors, HasSubstr("/nonexistent/state"));
}

TEST_F(StoredParameters, AreRecordedInTheJournal) {
  const std::string journal = (directory.path() / "run.journal").string();
  {
    RunningService service(flags("lockstep"));
    expect_done("write 1.2 profile_velocity 4321");
    expect_done("store 1.2");
    service.stop();
  }
  {
    RunningService service(flags("lockstep") + " --journal " + journal);
    for (const char* const words :
         {"enable 1.2", "move 1.2 100", "write 1.1 0x6065 5000", "store 1.1", "restore 1.2",
          "snapshot take", "power-cycle 1.1", "power-cycle 1.2", "snapshot restore 1",
          "power-cycle 1.2", "enable 1.2", "move 1.2 500"}) {
      expect_done(words);
    }
    service.stop();
  }
  const Finished replayed = Process(VDRIVE_SERVICE, {"--replay", journal}).wait();
  EXPECT_EQ(replayed.code, 0) << replayed.errors;
  EXPECT_THAT(replayed.output, HasSubstr("all checks agree"));
}

/// @return 6081h, or -1.
int shown_velocity() {
  const std::string output = tool("read 1.1 profile_velocity --json").output;
  const std::string key = "\"value\":";
  const std::size_t place = output.find(key);
  return place == std::string::npos ? -1 : std::atoi(output.c_str() + place + key.size());
}

TEST_F(StoredParameters, SurviveAKillOfTheServiceDuringASave) {
  const int kills = number_of<int>({.usual = 3, .full = 3, .nightly = 60});
  int saved = 68'267;
  for (int round = 1; round <= kills; ++round) {
    RunningService service(flags("realtime"));
    const int found = shown_velocity();
    ASSERT_EQ(found, saved) << "round " << round;
    expect_done("write 1.1 profile_velocity " + std::to_string(round));
    const auto before = stamps();
    Process store(VDRIVE_TOOL, tool_arguments("store 1.1 --timeout 2"));
    // Kills the service as soon as a file changes, in the middle of the save.
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (stamps() == before && std::chrono::steady_clock::now() < deadline) {
    }
    service.kill();
    const bool is_acknowledged = store.wait().code == 0;
    // An unacknowledged value may or may not be stored, but never in part.
    const RunningService next(flags("realtime"));
    const int kept = shown_velocity();
    EXPECT_TRUE(kept == round || (kept == saved && !is_acknowledged)) << "round " << round;
    EXPECT_THAT(tool("status 1.1").output, testing::Not(HasSubstr("Fault")));
    saved = kept;
  }
}

}  // namespace
}  // namespace vdrive::test
