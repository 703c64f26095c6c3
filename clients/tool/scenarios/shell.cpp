// SPDX-License-Identifier: Apache-2.0
#include "scenarios/shell.hpp"

#include "base/usage_error.hpp"
#include "execution/executor.hpp"
#include "language/completion.hpp"
#include "language/scenario.hpp"
#include "output/junit.hpp"
#include "scenarios/scenario_run.hpp"
#include "terminal/line_reader.hpp"

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
  Shell(const GlobalOptions& options, client::Session& session, Interrupt& interrupt,
        Terminal& terminal)
      : options_(options),
        session_(session),
        interrupt_(interrupt),
        terminal_(terminal),
        executor_(session, terminal, options.json, false),
        reader_(history_file(), [this](const std::string& line) {
          return complete_line(line, names_of(session_));
        }) {}

  ExitCode run() {
    interrupt_.arm([this] {
      session_.interrupt();
      // A person's Ctrl-C drops the line, also where the terminal has not left its own editing of
      // lines yet and sends it as a signal.
      const bool ends_wait = is_waiting_ && !reader_.is_interactive();
      if (ends_wait || interrupt_.is_termination()) reader_.end();
    });
    ExitCode first = ExitCode::ok;
    while (const auto line = next_line()) {
      if (*line == "exit" || *line == "quit") break;
      const ExitCode code = carry_out(*line);
      if (first == ExitCode::ok) first = code;
      if (!terminal_.is_open()) break;
    }
    interrupt_.disarm();
    return reader_.is_interactive() ? ExitCode::ok : first;
  }

 private:
  std::optional<std::string> next_line() {
    is_waiting_ = true;
    auto line = reader_.next();
    is_waiting_ = false;
    return line;
  }

  ExitCode carry_out(const std::string& line) {
    if (interrupt_.take()) session_.end_interrupt();
    ExitCode code = ExitCode::ok;
    try {
      std::vector<std::string> words = split_words(line);
      if (words.empty()) return code;
      const Outcome outcome = carry_out(parse_shell_command(std::move(words)));
      // An interrupted command needs no reason why it failed.
      const bool is_told = !outcome && !interrupt_.happened();
      if (is_told) terminal_.complain("vdrive: " + outcome.message());
      code = exit_code_of(outcome.kind());
    } catch (const UsageError& error) {
      terminal_.complain(std::string("vdrive: ") + error.what());
      code = ExitCode::usage;
    } catch (const std::exception& error) {
      terminal_.complain(std::string("vdrive: ") + error.what());
      code = ExitCode::failed;
    }
    terminal_.end_live();
    if (interrupt_.take()) {
      session_.end_interrupt();
      code = ExitCode::interrupted;
    }
    return code;
  }

  Outcome carry_out(const Invocation& invocation) {
    if (!invocation.command) {
      print(invocation.text);
      return {};
    }
    const auto timeout = invocation.options.timeout ? invocation.options.timeout : options_.timeout;
    const bool is_json = options_.json || invocation.options.json;
    if (const auto* const run = std::get_if<RunCommand>(&*invocation.command)) {
      JunitReport junit(run->junit);
      const auto scenarios = load_scenarios(run->files, settings_of(run->settings));
      return run_scenarios(scenarios,
                           {.is_json = is_json, .is_live = run->live, .timeout = timeout}, junit,
                           session_, terminal_);
    }
    executor_.set_json(is_json);
    return executor_.execute(*invocation.command, timeout);
  }

  void print(std::string text) {
    while (text.ends_with('\n')) text.pop_back();
    terminal_.print(text);
  }

  const GlobalOptions& options_;
  client::Session& session_;
  Interrupt& interrupt_;
  Terminal& terminal_;
  Executor executor_;
  LineReader reader_;
  std::atomic<bool> is_waiting_ = false;
};

}  // namespace

ExitCode run_shell(const GlobalOptions& options, client::Session& session, Interrupt& interrupt,
                   Terminal& terminal) {
  return Shell(options, session, interrupt, terminal).run();
}

}  // namespace vdrive::tool
