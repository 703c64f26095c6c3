// SPDX-License-Identifier: Apache-2.0
// The same program on two benches of one process, at the same time: the same answers, axes and
// journals. A thread sanitizer sees both benches; tests/bench/both_wires_test.cpp compares one of
// them with DDS.
#include "bench/random_program.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/bench/bench.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <future>
#include <string>
#include <variant>
#include <vector>

namespace vdrive::bench {
namespace {

using Path = std::filesystem::path;

constexpr std::uint32_t kPrograms = 10;

/// @return the logs of the programs with the seeds 1 to kPrograms.
std::string logs_of_a_bench(const Path& journal, const Path& state) {
  const Bench bench({.configuration_file = VDRIVE_SOURCE_DIR "/tests/data/patient.yaml",
                     .axes = 3,
                     .clock = ClockMode::lockstep,
                     .state_directory = state,
                     .journal = journal});
  client::Session session = bench.session();
  const auto begin = session.take_snapshot(1).value();
  std::string logs;
  for (std::uint32_t seed = 1; seed <= kPrograms; ++seed) {
    EXPECT_TRUE(session.release(1));
    EXPECT_TRUE(session.restore_snapshot(1, begin));
    logs += RandomProgram(session, seed).run();
  }
  return logs;
}

/// What a record is, for a person who looks for a difference.
struct RecordText {
  std::string operator()(const service::JournalChange& change) const {
    return "change " + std::to_string(static_cast<int>(change.kind)) + " of axis " +
           std::to_string(change.axis) + ": " + address_text(change.address) + " = " +
           std::to_string(change.value);
  }

  std::string operator()(const service::JournalTick& tick) const {
    return "tick " + std::to_string(tick.number);
  }

  std::string operator()(const service::JournalSnapshot& snapshot) const {
    return "snapshot " + std::to_string(static_cast<int>(snapshot.cause)) + " at tick " +
           std::to_string(snapshot.tick);
  }

  std::string operator()(const service::JournalEnd& end) const {
    return "end after " + std::to_string(end.ticks) + " ticks, " + std::to_string(end.changes) +
           " changes, " + std::to_string(end.lost) + " lost";
  }
};

/// @return the first difference, or an empty text.
std::string difference_of(const std::vector<service::JournalRecord>& one,
                          const std::vector<service::JournalRecord>& other) {
  const auto [here, there] = std::ranges::mismatch(one, other);
  if (here == one.end() && there == other.end()) return "";
  const auto text_at = [](const auto& records, auto place) {
    return place == records.end() ? "no record" : std::visit(RecordText(), *place);
  };
  return "record " + std::to_string(here - one.begin()) + ": " + text_at(one, here) + "; " +
         text_at(other, there);
}

TEST(TwoBenchesOfAProcess, RepeatEachOtherInEveryTick) {
  const test::TemporaryDirectory directory;
  const auto path = [&directory](const char* name) {
    return directory.path() / name;
  };
  auto other = std::async(std::launch::async, logs_of_a_bench, path("journal.2"), path("state.2"));
  const std::string logs = logs_of_a_bench(path("journal.1"), path("state.1"));
  EXPECT_EQ(logs, other.get());
  const auto records = records_of(path("journal.1"));
  EXPECT_GT(records.size(), kPrograms);  // a snapshot each
  EXPECT_EQ(difference_of(records, records_of(path("journal.2"))), "");
}

}  // namespace
}  // namespace vdrive::bench
