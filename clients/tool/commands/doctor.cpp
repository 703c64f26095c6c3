// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/doctor.hpp"

#include "execution/connection.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"

namespace vdrive::tool {
namespace {

/// Checks this machine and finds the benches on the domain.
struct DoctorCommand {
  void declare(Arguments& /*arguments*/) {}

  /// The doctor checks the machine also where no session can be opened.
  static ExitCode start(const Program& program) {
    const GlobalOptions& options = program.options;
    const client::Outcome outcome = run_doctor(options, program.terminal, [&options] {
      return client::Session(session_options(options)).find_benches();
    });
    return finish(outcome, Interrupt(), false, program.terminal);
  }
};

}  // namespace

extern const CommandRow kDoctor =
    row_of<DoctorCommand>({.name = "doctor",
                           .group = CommandGroup::machine,
                           .summary = "Check this machine and its network, and show what to change",
                           .example = "doctor --interface 10.0.0.1",
                           .deepest = Place::command_line});

}  // namespace vdrive::tool
