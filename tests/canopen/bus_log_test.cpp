// SPDX-License-Identifier: Apache-2.0
#include "bus/bus_log.hpp"

#include "bus/asio.hpp"
#include "canopen/recorded_port.hpp"
#include "support/process_tree.hpp"
#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

std::string log_line(const Frame& frame, std::chrono::microseconds time) {
  std::string line;
  append_log_line(line, "vcan0", frame, time);
  return line;
}

TEST(BusLogLine, IsThatOfCanUtils) {
  EXPECT_EQ(log_line(data_frame(0x123, {0x00, 0x11}), 1'436'509'052'249'713us),
            "(1436509052.249713) vcan0 123#0011\n");
  EXPECT_EQ(log_line(data_frame(0x080, {}), 1'001us), "(0000000000.001001) vcan0 080#\n");
  EXPECT_EQ(log_line({.id = 0x1ABCDEF, .is_extended = true, .size = 1, .data = {0xFE}}, 2s),
            "(0000000002.000000) vcan0 01ABCDEF#FE\n");
  EXPECT_EQ(log_line({.id = 0x701, .is_remote = true}, 0us), "(0000000000.000000) vcan0 701#R\n");
  EXPECT_EQ(log_line({.id = 0x181, .is_remote = true, .size = 2}, 0us),
            "(0000000000.000000) vcan0 181#R2\n");
}

struct LoggedBus {
  explicit LoggedBus(const std::filesystem::path& file, std::uint64_t most_bytes = 1'000) {
    log.emplace(context, bus, host, BusLogSettings{.file = file, .most_bytes = most_bytes});
  }

  void send(std::uint32_t id) {
    host.time += 1ms;
    bus.send(data_frame(id, {0x42}), nullptr);
  }

  void turn() {
    context.restart();
    context.poll();
  }

  asio::io_context context;
  Bus bus;
  RecordedHost host;
  std::optional<BusLog> log;
};

TEST(BusLog, HasTheFramesOfATurnOfTheLoopAtItsEnd) {
  const test::TemporaryDirectory directory;
  const std::filesystem::path file = directory.path() / "bus.log";
  LoggedBus logged(file);
  logged.send(0x701);
  logged.send(0x702);
  logged.turn();
  EXPECT_EQ(test::text_of(file),
            "(0000000000.001000) can0 701#42\n(0000000000.002000) can0 702#42\n");
  logged.send(0x703);
  EXPECT_EQ(logged.log->flush(), 0U);
  EXPECT_THAT(test::text_of(file), HasSubstr("703#42\n"));
  logged.send(0x704);
  logged.log.reset();
  EXPECT_THAT(test::text_of(file), HasSubstr("704#42\n")) << "an end loses nothing";
  logged.send(0x705);
  logged.turn();
}

TEST(BusLog, ReplacesAFileOfAnEarlierRun) {
  const test::TemporaryDirectory directory;
  const std::filesystem::path file = directory.path() / "bus.log";
  std::ofstream(file) << "old\n";
  const LoggedBus logged(file);
  EXPECT_EQ(test::text_of(file), "");
}

TEST(BusLog, ReportsAFullDiskOnceAndCountsWhatIsMissing) {
  LoggedBus logged("/dev/full");
  logged.send(0x701);
  logged.send(0x702);
  logged.turn();
  EXPECT_THAT(logged.host.reports,
              ElementsAre(HasSubstr("log '/dev/full' cannot be written: No space left on device")));
  logged.send(0x703);
  logged.turn();
  EXPECT_EQ(logged.host.reports.size(), 1U);
  EXPECT_EQ(logged.log->flush(), 3U);
}

// A line has 32 bytes, so three lines fit into 100.
TEST(BusLog, EndsAtItsLimit) {
  const test::TemporaryDirectory directory;
  const std::filesystem::path file = directory.path() / "bus.log";
  LoggedBus logged(file, 100);
  for (int i = 0; i < 5; ++i) {
    logged.send(0x701);
    logged.turn();
  }
  EXPECT_EQ(std::filesystem::file_size(file), 96U);
  EXPECT_THAT(logged.host.reports, ElementsAre(HasSubstr("has reached its limit of 100 bytes")));
  EXPECT_EQ(logged.log->flush(), 2U);
}

TEST(BusLog, SaysWhyItsFileCannotBeOpened) {
  const test::TemporaryDirectory directory;
  try {
    const LoggedBus logged(directory.path() / "missing" / "bus.log");
    FAIL() << "it was opened";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("bus.log' cannot be opened: No such file or directory"));
  }
}

}  // namespace
}  // namespace vdrive::canopen
