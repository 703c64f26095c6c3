// SPDX-License-Identifier: Apache-2.0
#include "base/service_program.hpp"
#include "diagnosis/measurement.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "terminal/interrupt.hpp"

#include <string>

namespace vdrive::tool {
namespace {

/// Measures the performance of this machine on private benches.
struct BenchCommand {
  std::string service{};
  bool is_quick = false;

  void declare(Arguments& arguments) {
    arguments.service(service);
    arguments.flag("--quick", is_quick, "A few seconds, at most 1,024 axes: a first estimate");
  }

  ExitCode start(const Program& program) const {
    Interrupt interrupt;
    return run_measurement(
        {.service = find_service(service), .is_quick = is_quick, .is_json = program.options.json},
        interrupt, program.terminal);
  }
};

}  // namespace

extern const CommandRow kBench = row_of<BenchCommand>(
    {.name = "bench",
     .group = CommandGroup::machine,
     .summary =
         "Measure in a minute how many axes this machine can run, and how late its ticks are",
     .example = "bench --json",
     .deepest = Place::command_line});

}  // namespace vdrive::tool
