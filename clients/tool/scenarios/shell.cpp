// SPDX-License-Identifier: Apache-2.0
#include "scenarios/shell.hpp"

#include "base/usage_error.hpp"
#include "execution/command_context.hpp"
#include "execution/output.hpp"
#include "language/bench_names.hpp"
#include "language/command_line.hpp"
#include "language/scenario.hpp"
#include "scenarios/line_reader.hpp"
#include "terminal/terminal.hpp"

#include <atomic>
#include <exception>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

class Shell {
 public:
  Shell(const Program& program, client::Session& session, Interrupt& interrupt)
      : program_(program),
        session_(session),
        interrupt_(interrupt),
        terminal_(program.terminal),
        context_(session, {program.terminal, program.options.json, false}, program.commands),
        reader_(history_file(), [this](const std::string& line) {
          return complete_line(program_.commands, line, names_of(session_));
        }) {
    context_.outlives_failures = true;
  }

  ExitCode run() {
    interrupt_.arm([this] {
      session_.interrupt();
      // A person's Ctrl-C drops the line, also where the terminal has not left its own editing of
      // lines yet and sends it as a signal.
      const bool ends_wait = is_waiting_ && !reader_.is_interactive();
      if (ends_wait || interrupt_.is_termination()) end_by_signal();
    });
    ExitCode first = ExitCode::ok;
    while (const auto line = next_line()) {
      if (*line == "exit" || *line == "quit") break;
      const ExitCode code = carry_out(*line);
      if (first == ExitCode::ok) first = code;
      if (!terminal_.is_open()) break;
    }
    interrupt_.disarm();
    if (is_ended_by_signal_ || interrupt_.is_termination()) return ExitCode::interrupted;
    return reader_.is_interactive() ? ExitCode::ok : first;
  }

 private:
  void end_by_signal() {
    is_ended_by_signal_ = true;
    reader_.end();
  }

  std::optional<std::string> next_line() {
    is_waiting_ = true;
    // Between two lines it is no command that a signal ends.
    if (!reader_.is_interactive() && interrupt_.happened()) end_by_signal();
    auto line = reader_.next();
    is_waiting_ = false;
    if (is_ended_by_signal_) line.reset();  // the reader may have lines ahead
    return line;
  }

  /// @return whether a signal has come since the last call. Without a terminal nobody types the
  /// next
  ///         line: whoever interrupts a file of commands does not want the rest of it.
  bool take_interrupt() {
    if (!interrupt_.take()) return false;
    session_.end_interrupt();
    if (!reader_.is_interactive()) end_by_signal();
    return true;
  }

  ExitCode carry_out(const std::string& line) {
    if (take_interrupt() && is_ended_by_signal_) return ExitCode::interrupted;
    ExitCode code = ExitCode::ok;
    try {
      std::vector<std::string> words = split_words(line);
      if (words.empty()) return code;
      const Outcome outcome = carry_out(parse_shell_command(program_.commands, std::move(words)));
      // An interrupted command needs no reason why it failed.
      const bool is_told = !outcome && !interrupt_.happened();
      if (is_told) terminal_.complain("vdrive: " + outcome.message());
      code = exit_code_of(outcome.kind());
    } catch (const UsageError& error) {
      report_usage({terminal_, program_.options.json, false}, error.what());
      code = ExitCode::usage;
    } catch (const std::exception& error) {
      terminal_.complain(std::string("vdrive: ") + error.what());
      code = ExitCode::failed;
    }
    terminal_.end_live();
    if (take_interrupt()) code = ExitCode::interrupted;
    return code;
  }

  Outcome carry_out(const Invocation& invocation) {
    if (!invocation.command) {
      print(invocation.text);
      return {};
    }
    const GlobalOptions& options = program_.options;
    context_.output.is_json = options.json || invocation.options.json;
    return execute(*invocation.command, context_,
                   invocation.options.timeout ? invocation.options.timeout : options.timeout);
  }

  void print(std::string text) {
    while (text.ends_with('\n')) text.pop_back();
    terminal_.print(text);
  }

  const Program& program_;
  client::Session& session_;
  Interrupt& interrupt_;
  Terminal& terminal_;
  CommandContext context_;
  LineReader reader_;
  std::atomic<bool> is_waiting_ = false;
  std::atomic<bool> is_ended_by_signal_ = false;
};

}  // namespace

ExitCode run_shell(const Program& program, client::Session& session, Interrupt& interrupt) {
  return Shell(program, session, interrupt).run();
}

}  // namespace vdrive::tool
