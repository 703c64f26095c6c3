// SPDX-License-Identifier: Apache-2.0
#include "scenarios/shell.hpp"

#include "execution/connection.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "terminal/interrupt.hpp"

#include <string_view>

namespace vdrive::tool {
namespace {

constexpr std::string_view kShellHelp =
    R"(Commands are those of a scenario, and watch, events, record, plot and run, without 'vdrive'. The
session keeps the axes that it commands until the shell ends: at 'exit', 'quit', Ctrl-D or the end of
the input. 'help' lists the commands, 'help move' explains one. Tab completes, the arrow keys find
earlier lines, Ctrl-C ends the command that runs.

Example:
  vdrive shell
  vdrive shell < commands.txt)";

/// Reads commands from standard input.
struct ShellCommand {
  void declare(Arguments& /*arguments*/) {}

  static ExitCode start(const Program& program) {
    Interrupt interrupt;
    interrupt.before_exit([&program] {
      program.terminal.leave_screen_at_once();
    });
    client::Session session(session_options(program.options));
    return run_shell(program, session, interrupt);
  }
};

}  // namespace

extern const CommandRow kShell =
    row_of<ShellCommand>({.name = "shell",
                          .group = CommandGroup::scenarios,
                          .summary = "Execute commands line by line, in one session",
                          .example = "shell",
                          .help = kShellHelp,
                          .deepest = Place::command_line});

}  // namespace vdrive::tool
