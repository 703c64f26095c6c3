// SPDX-License-Identifier: Apache-2.0
// The same program over the local bus and over DDS: the same answers, the same axes in every tick
// that is seen, and the same journal, which has every tick.
#include "bench/random_program.hpp"
#include "client/session_options.hpp"
#include "support/effort.hpp"
#include "support/temporary_directory.hpp"
#include "tool/process.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

namespace vdrive::bench {
namespace {

using client::Session;

constexpr int kAxes = 3;
const auto kSequences =
    test::number_of<std::uint32_t>({.usual = 60, .full = 1'000, .nightly = 10'000});
constexpr const char* kConfiguration = VDRIVE_SOURCE_DIR "/tests/data/patient.yaml";

/// The same bench over both wires, each with a journal.
class BothWires : public testing::Test {
 protected:
  void run_sequences(Session& local, Session& over_dds) {
    const std::array sessions{&local, &over_dds};
    std::array<std::uint64_t, 2> begins{};
    for (std::size_t wire = 0; wire < sessions.size(); ++wire) {
      begins[wire] = sessions[wire]->take_snapshot(1).value();
    }
    for (std::uint32_t seed = 1; seed <= kSequences; ++seed) {
      std::array<std::string, 2> logs;
      for (std::size_t wire = 0; wire < sessions.size(); ++wire) {
        ASSERT_TRUE(sessions[wire]->release(1));
        ASSERT_TRUE(sessions[wire]->restore_snapshot(1, begins[wire]));
        logs[wire] = RandomProgram(*sessions[wire], seed).run();
      }
      ASSERT_EQ(logs[0], logs[1]) << "seed " << seed;
    }
  }

  [[nodiscard]] std::filesystem::path path(const char* name) const {
    return directory_.path() / name;
  }

 private:
  const test::TemporaryDirectory directory_;
};

TEST_F(BothWires, GiveARandomProgramTheSameAnswersTheSameAxesAndTheSameJournal) {
  {
    test::RunningService running("--clock lockstep --config " + std::string(kConfiguration) +
                                 " --axes " + std::to_string(kAxes) + " --state " +
                                 path("state.dds").string() + " --journal " +
                                 path("journal.dds").string());
    const Bench bench({.configuration_file = kConfiguration,
                       .axes = kAxes,
                       .clock = ClockMode::lockstep,
                       .state_directory = path("state.local"),
                       .journal = path("journal.local")});
    Session over_dds(test::options());
    Session local = bench.session();
    run_sequences(local, over_dds);
    ASSERT_EQ(running.stop().code, 0);
  }
  const auto local = records_of(path("journal.local"));
  const auto over_dds = records_of(path("journal.dds"));
  ASSERT_EQ(local.size(), over_dds.size());
  EXPECT_GT(local.size(), kSequences);  // a snapshot each
  for (std::size_t i = 0; i < local.size(); ++i) {
    ASSERT_TRUE(local[i] == over_dds[i])
        << "record " << i << " of " << local.size() << ", of kind " << local[i].index();
  }
}

}  // namespace
}  // namespace vdrive::bench
