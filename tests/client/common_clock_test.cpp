// SPDX-License-Identifier: Apache-2.0
// Programs that step a bench together.
#include "client/session_options.hpp"
#include "support/effort.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

namespace vdrive::client {
namespace {

using test::RunningService;

constexpr std::size_t kPrograms = 3;

/// The digest of the observations of each program.
using Seen = std::array<std::string, kPrograms>;

/// Runs the programs on a new bench; each starts after the previous one has joined the clock.
/// @param first the program that is started first
/// @param is_configured whether the bench waits for all programs; otherwise the programs wait for
///        each other
Seen seen_in_a_run(std::size_t first, bool is_configured) {
  const std::string count = std::to_string(kPrograms);
  const RunningService service(test::patient("--clock lockstep --axes " + count) +
                               (is_configured ? " --steppers " + count : ""));
  std::array<std::unique_ptr<test::Process>, kPrograms> programs;
  for (std::size_t place = 0; place < kPrograms; ++place) {
    const std::size_t number = (first + place) % kPrograms;
    programs[number] = std::make_unique<test::Process>(
        VDRIVE_CO_STEPPER,
        std::vector<std::string>{std::to_string(test::test_domain()), std::to_string(number + 1),
                                 count, is_configured ? "0" : count});
    EXPECT_EQ(programs[number]->read_line(), "joined");
  }
  Seen seen;
  std::ranges::transform(programs, seen.begin(), [](const auto& program) {
    return program->read_line();
  });
  for (const auto& program : programs) EXPECT_EQ(program->wait().code, 0);
  return seen;
}

// If the programs did not wait, the first would step alone until the next had joined.
TEST(CommonClock, GivesThreeProgramsTheSameBitsInEachRunInWhateverOrderTheyStart) {
  const int runs = test::number_of<int>({.usual = 3, .full = 50, .nightly = 200});
  const Seen first = seen_in_a_run(0, false);
  for (int run = 1; run < runs; ++run) {
    const auto order = static_cast<std::size_t>(run) % kPrograms;
    ASSERT_EQ(seen_in_a_run(order, run % 2 == 0), first) << "run " << run;
  }
}

}  // namespace
}  // namespace vdrive::client
