// SPDX-License-Identifier: Apache-2.0
// The same programs over the local bus and over DDS must give the same answers, the same axes in
// every observed tick, the same events, and the same journal, which has every tick.
#include "bench/random_program.hpp"
#include "client/session_options.hpp"
#include "support/effort.hpp"
#include "support/journal_comparison.hpp"
#include "support/temporary_directory.hpp"
#include "tool/process.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/client.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <iostream>
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
  /// @param local, over_dds each with two sessions of a bench
  static void run_sequences(ProgrammedBench& local, ProgrammedBench& over_dds) {
    for (std::uint32_t seed = 1; seed <= kSequences; ++seed) {
      ASSERT_EQ(difference_of(local.run(seed), over_dds.run(seed)), "") << "seed " << seed;
    }
  }

  static void expect_same_news(ProgrammedBench& local, ProgrammedBench& over_dds) {
    EXPECT_EQ(local.await_same_news(over_dds), "");
    EXPECT_FALSE(local.refusals().empty());
    const std::uint64_t compared = told_to_both(local.events(), over_dds.events());
    std::cout << compared << " of " << local.events().count() << " events compared\n";
    EXPECT_GT(compared, kSequences);
  }

  [[nodiscard]] std::filesystem::path path(const char* name) const {
    return directory_.path() / name;
  }

 private:
  const test::TemporaryDirectory directory_;
};

TEST_F(BothWires, GiveRandomProgramsTheSameAnswersAxesEventsAndJournal) {
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
    Session first_over_dds(test::options());
    Session second_over_dds(test::options());
    Session first_local = bench.session();
    Session second_local = bench.session();
    ProgrammedBench over_dds(first_over_dds, second_over_dds);
    ProgrammedBench local(first_local, second_local);
    ASSERT_NO_FATAL_FAILURE(run_sequences(local, over_dds));
    expect_same_news(local, over_dds);
    ASSERT_EQ(running.stop().code, 0);
  }
  const test::JournalComparison journals =
      test::compare_journals(path("journal.local"), path("journal.dds"));
  ASSERT_EQ(journals.difference, "");
  EXPECT_GT(journals.snapshots, kSequences);  // one per program, and one at the start
}

}  // namespace
}  // namespace vdrive::bench
