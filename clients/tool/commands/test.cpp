// SPDX-License-Identifier: Apache-2.0
#include "base/usage_error.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "private_domain.hpp"
#include "scenarios/scenario_tests.hpp"
#include "terminal/interrupt.hpp"

#include <algorithm>
#include <string>
#include <thread>

namespace vdrive::tool {
namespace {

std::size_t parse_jobs(const std::string& text) {
  constexpr std::uint64_t kMostJobs = process::PrivateDomain::kMostOfOneUser;
  const std::uint64_t jobs = parse_number(text, "number of jobs", kMostJobs);
  if (jobs == 0) throw UsageError("--jobs: at least one file must run");
  return jobs;
}

/// Runs scenarios on benches of their own.
struct TestCommand {
  ScenarioTestOptions tests{};

  void declare(Arguments& arguments) {
    tests.jobs = std::max(std::thread::hardware_concurrency(), 1U);
    tests.scenarios.declare(arguments, "Scenario");
    tests.benches.declare(arguments);
    arguments.option("--jobs", "N", tests.jobs,
                     "How many files run at the same time; default: one per processor", parse_jobs);
  }

  ExitCode start(const Program& program) const {
    Interrupt interrupt;
    return run_scenario_tests(tests, program, interrupt);
  }
};

}  // namespace

extern const CommandRow kTest =
    row_of<TestCommand>({.name = "test",
                         .group = CommandGroup::scenarios,
                         .summary = "Run scenario files in parallel, each on a separate bench",
                         .example = "test tests/*.scn --config bench.yaml --junit out.xml",
                         .deepest = Place::command_line});

}  // namespace vdrive::tool
