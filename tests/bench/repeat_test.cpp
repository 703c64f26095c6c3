// SPDX-License-Identifier: Apache-2.0
// The same programs on two benches of one process, at the same time, must give the same answers,
// axes, events and journals. A thread sanitizer sees both benches; tests/bench/both_wires_test.cpp
// compares one with DDS.
#include "bench/random_program.hpp"
#include "support/journal_comparison.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/bench/bench.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <future>
#include <string>

namespace vdrive::bench {
namespace {

using Path = std::filesystem::path;

constexpr std::uint32_t kPrograms = 10;

/// A bench with its sessions.
struct OneOfTwo {
  OneOfTwo(const Path& journal, const Path& state)
      : bench({.configuration_file = VDRIVE_SOURCE_DIR "/tests/data/patient.yaml",
               .axes = 3,
               .clock = ClockMode::lockstep,
               .state_directory = state,
               .journal = journal}) {}

  /// @return the logs of the programs with seeds 1 to kPrograms.
  std::string run() {
    std::string logs;
    for (std::uint32_t seed = 1; seed <= kPrograms; ++seed) logs += programs.run(seed);
    return logs;
  }

  const Bench bench;
  client::Session first = bench.session();
  client::Session second = bench.session();
  ProgrammedBench programs{first, second};
};

TEST(TwoBenchesOfAProcess, RepeatEachOtherInEveryTick) {
  const test::TemporaryDirectory directory;
  const auto path = [&directory](const char* name) {
    return directory.path() / name;
  };
  {
    OneOfTwo one(path("journal.1"), path("state.1"));
    OneOfTwo other(path("journal.2"), path("state.2"));
    auto logs_of_other = std::async(std::launch::async, [&other] {
      return other.run();
    });
    const std::string logs = one.run();
    EXPECT_EQ(difference_of(logs, logs_of_other.get()), "");
    EXPECT_EQ(one.programs.await_same_news(other.programs), "");
  }
  const test::JournalComparison journals =
      test::compare_journals(path("journal.1"), path("journal.2"));
  ASSERT_EQ(journals.difference, "");
  EXPECT_GT(journals.snapshots, kPrograms);  // one per program, and one at the start
}

}  // namespace
}  // namespace vdrive::bench
