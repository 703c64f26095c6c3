// SPDX-License-Identifier: Apache-2.0
// C programs with Cyclone DDS and the service of this build.
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/session.hpp"
#include "vendor/peer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

namespace vdrive::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::StartsWith;

Finished client_on(const std::string& bench, const std::string& axis) {
  setenv("CYCLONEDDS_URI", kCycloneOnLoopback, 1);  // NOLINT(concurrency-mt-unsafe): one thread
  return Process(VDRIVE_VENDOR_CLIENT, {std::to_string(test_domain()), bench, axis}).wait();
}

// A client that is killed leaves the axis free and in fault 8130h (6007h = 1).
Finished client_after_a_killed_one() {
  setenv("CYCLONEDDS_URI", kCycloneOnLoopback, 1);  // NOLINT(concurrency-mt-unsafe): one thread
  Process killed(VDRIVE_VENDOR_CLIENT, {std::to_string(test_domain()), "1", "2"});
  std::string line = killed.read_line();
  while (!line.empty() && !line.starts_with("8 start")) line = killed.read_line();
  killed.send(SIGKILL);
  (void)killed.wait();
  const auto options = [] {
    client::SessionOptions result;
    result.domain = test_domain();
    return result;
  }();
  client::Session session(options);
  const auto axis = session.axis("1.2");
  if (!axis) throw std::runtime_error(axis.outcome().message());
  const auto lost = axis->wait_until(
      [](const client::AxisSnapshot& shown) {
        return shown.state() == PowerState::fault && shown.owner_session == 0;
      },
      std::chrono::seconds(30));
  if (!lost) throw std::runtime_error(lost.outcome().message());
  EXPECT_EQ(lost->status.error_code, 0x8130);
  return client_on("1", "2");
}

/// The statuswords are those of the manual's "absolute position mode, forward"; 0x233 is Switched
/// on, which the manual's state table has between 0x231 and 0x637.
void expect_the_manuals_rows(const Finished& client, const std::string& clock) {
  ASSERT_EQ(client.code, 0) << client.output << client.errors;
  EXPECT_THAT(
      client.lines(),
      ElementsAre("bench 1 \"demo\": 2 axes, " + clock, StartsWith("axis 2 held in epoch "),
                  "1 disable: 6040h = 0x06, 6041h = 0x231", "2 profile position mode: 6061h = 1",
                  StartsWith("3 to 6 target 10000"), "7 switch on: 6040h = 0x07, 6041h = 0x233",
                  "7 enable: 6040h = 0x0F, 6041h = 0x637", "8 start: 6040h = 0x3F, 6041h = 0x1237",
                  "9 arrived: 6041h = 0x1637, 6062h = 10000, 6064h = 10000",
                  "10 disable: 6040h = 0x06, 6041h = 0x231", "released"));
}

TEST(CycloneClient, RunsTheManualsForwardExampleInLockStep) {
  const RunningService service("--clock lockstep");
  expect_the_manuals_rows(client_on("1", "2"), "lock-step");
}

/// Runs four times as fast as the wall clock, with a status frame every millisecond. The watchdog
/// allows for a loaded machine; the move takes 2.5 s, so signs of life are still needed.
class FastBench {
 public:
  FastBench() {
    std::ofstream(file_) << "clock: {rate: 4}\n"
                            "status: {every_ticks: 4}\n"
                            "watchdog: {timeout_ms: 1000}\n";
    service_.emplace("--config " + file_.string());
  }

  ~FastBench() { std::filesystem::remove(file_); }

  FastBench(const FastBench&) = delete;
  FastBench& operator=(const FastBench&) = delete;

 private:
  std::filesystem::path file_ = std::filesystem::temp_directory_path() /
                                ("vdrive-vendor-" + std::to_string(getpid()) + ".yaml");
  std::optional<RunningService> service_;
};

TEST(CycloneClient, RunsTheManualsForwardExampleInRealTime) {
  const FastBench bench;
  expect_the_manuals_rows(client_on("1", "2"), "real time");
}

// The sequence of docs/reference/wire.md, step 5: first the fault reset. 0x250 is Switch on
// disabled, reached by transition 15.
TEST(CycloneClient, RunsTheManualsForwardExampleAfterAKilledClient) {
  const FastBench bench;
  const Finished client = client_after_a_killed_one();
  EXPECT_EQ(client.code, 0) << client.output << client.errors;
  EXPECT_THAT(client.lines(), Contains("0 fault reset: 6040h = 0x80, 6041h = 0x250"));
  EXPECT_THAT(client.lines(), Contains("9 arrived: 6041h = 0x1637, 6062h = 10000, 6064h = 10000"));
}

TEST(CycloneClient, ReportsAnAxisThatDoesNotExist) {
  const RunningService service("--clock lockstep");
  const Finished client = client_on("1", "9");
  EXPECT_EQ(client.code, 1);
  EXPECT_EQ(client.errors, "vendor_client: acquire: refused with reason 4\n");  // UNKNOWN_AXIS
}

TEST(RawExample, MovesTheAxisToTheTargetAndLeavesItThere) {
  const FastBench bench;
  unsetenv("CYCLONEDDS_URI");  // NOLINT(concurrency-mt-unsafe): it finds loopback by itself
  const Finished example = Process(VDRIVE_RAW_EXAMPLE, {std::to_string(test_domain())}).wait();
  ASSERT_EQ(example.code, 0) << example.output << example.errors;
  EXPECT_THAT(example.lines(), Contains("position 10000"));
  const Finished position = tool("read 1.1 0x6064");
  EXPECT_EQ(position.code, 0) << position.errors;
  EXPECT_THAT(position.output, testing::HasSubstr("10000"));
}

TEST(RawExample, IsShorterThan200Lines) {
  std::ifstream file(VDRIVE_SOURCE_DIR "/clients/examples/06_raw_dds/raw_dds.c");
  int lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  EXPECT_GT(lines, 0);
  EXPECT_LT(lines, 200);
}

}  // namespace
}  // namespace vdrive::test
