// SPDX-License-Identifier: Apache-2.0
#include "base/usage_error.hpp"
#include "child_process.hpp"
#include "execution/command_context.hpp"
#include "execution/connection.hpp"
#include "language/arguments.hpp"
#include "language/bench_names.hpp"
#include "language/command.hpp"
#include "language/command_line.hpp"
#include "language/scenario.hpp"
#include "output/record.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/terminal.hpp"

#include <histedit.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <clocale>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cwchar>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

constexpr int kKeptLines = 1000;

/// Waits for standard input. @return false when `end` is readable.
bool wait_for_input(int end) {
  std::array<pollfd, 2> ready{pollfd{STDIN_FILENO, POLLIN, 0}, pollfd{end, POLLIN, 0}};
  while (poll(ready.data(), ready.size(), -1) < 0) {
  }
  return ready[1].revents == 0;
}

/// @return the common prefix of all words.
std::string common_beginning(const std::vector<std::string>& words) {
  std::string common = words.front();
  for (const std::string& word : words) {
    const auto [end, other] = std::ranges::mismatch(common, word);
    common.erase(end, common.end());
  }
  return common;
}

std::size_t word_start(std::string_view line) {
  const std::size_t blank = line.find_last_of(" \t");
  return blank == std::string_view::npos ? 0 : blank + 1;
}

/// @return the history file of the shell, whose directory is created; empty if there is no home
///         directory.
std::string history_file() {
  const auto environment = [](const char* name) {
    const char* const value =
        std::getenv(name);  // NOLINT(concurrency-mt-unsafe): no thread sets any
    return std::string(value == nullptr ? "" : value);
  };
  std::string state = environment("XDG_STATE_HOME");
  if (state.empty() && !environment("HOME").empty()) state = environment("HOME") + "/.local/state";
  if (state.empty()) return {};
  const std::filesystem::path directory = std::filesystem::path(state) / "vdrive";
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  return error ? std::string() : (directory / "history").string();
}

/// Wraps libedit. Its interface has variable arguments, and its callbacks find this object in the
/// client data of the editor.
// NOLINTBEGIN(*-vararg)
class Editor {
 public:
  Editor(int end, CommandTable commands, client::Session& session)
      : end_(end),
        file_(history_file()),
        commands_(commands),
        session_(session),
        history_(history_init()),
        editor_(el_init("vdrive", stdin, stdout, stderr)) {
    // libedit reads multi-byte characters in the encoding of the locale.
    // NOLINTNEXTLINE(concurrency-mt-unsafe): no other thread uses the locale
    static_cast<void>(std::setlocale(LC_CTYPE, ""));
    HistEvent event{};
    history(history_, &event, H_SETSIZE, kKeptLines);
    history(history_, &event, H_SETUNIQUE, 1);
    if (!file_.empty()) history(history_, &event, H_LOAD, file_.c_str());
    el_set(editor_, EL_CLIENTDATA, this);
    el_set(editor_, EL_PROMPT, &prompt);
    el_set(editor_, EL_EDITOR, "emacs");
    el_set(editor_, EL_HIST, history, history_);
    el_set(editor_, EL_GETCFN, &read_character);
    el_set(editor_, EL_ADDFN, "vdrive-complete", "Complete the word", &complete);
    el_set(editor_, EL_BIND, "^I", "vdrive-complete", nullptr);
    // Ctrl-C is a character while a line is edited: it drops the line.
    el_set(editor_, EL_SETTY, "-d", "-isig", nullptr);
    el_set(editor_, EL_ADDFN, "vdrive-drop", "Drop the line", &drop);
    el_set(editor_, EL_BIND, "^C", "vdrive-drop", nullptr);
    el_source(editor_, nullptr);
  }

  ~Editor() {
    HistEvent event{};
    if (!file_.empty()) history(history_, &event, H_SAVE, file_.c_str());
    el_end(editor_);
    history_end(history_);
  }

  Editor(const Editor&) = delete;
  Editor& operator=(const Editor&) = delete;

  std::optional<std::string> next() {
    // The editor would prepare the terminal only after the prompt. Until then the terminal would
    // edit the input itself, and Ctrl-C would be a signal that no thread waits for.
    el_set(editor_, EL_PREP_TERM, 1);
    int length = 0;
    const char* const line = el_gets(editor_, &length);
    if (line == nullptr || length <= 0) return std::nullopt;
    std::string text(line, static_cast<std::size_t>(length));
    while (text.ends_with('\n')) text.pop_back();
    HistEvent event{};
    if (!text.empty()) history(history_, &event, H_ENTER, text.c_str());
    return text;
  }

 private:
  static char* prompt(EditLine* /*editor*/) {
    static std::array<char, 9> text{"vdrive> "};
    return text.data();
  }

  static Editor& of(EditLine* editor) {
    void* self = nullptr;
    el_get(editor, EL_CLIENTDATA, &self);
    return *static_cast<Editor*>(self);
  }

  /// @return as read(): 1, or 0 at the end.
  static int read_character(EditLine* editor, wchar_t* character) {
    std::mbstate_t state{};
    while (true) {
      char byte = 0;
      if (!wait_for_input(of(editor).end_) || read(STDIN_FILENO, &byte, 1) != 1) return 0;
      // NOLINTNEXTLINE(concurrency-mt-unsafe): the state is our own
      const std::size_t length = std::mbrtowc(character, &byte, 1, &state);
      if (length <= 1) return 1;
      // Not a character of this locale: dropped.
      if (length == static_cast<std::size_t>(-1)) state = {};
    }
  }

  static unsigned char drop(EditLine* editor, int /*key*/) {
    std::fputs("^C\n", stdout);
    const LineInfo* const line = el_line(editor);
    el_cursor(editor, static_cast<int>(line->lastchar - line->cursor));
    el_deletestr(editor, static_cast<int>(line->lastchar - line->buffer));
    return CC_REDISPLAY;
  }

  static unsigned char complete(EditLine* editor, int /*key*/) {
    const LineInfo* const shown = el_line(editor);
    const std::string line(shown->buffer, shown->cursor);
    Editor& self = of(editor);
    const std::vector<std::string> words =
        complete_line(self.commands_, line, names_of(self.session_));
    if (words.empty()) return CC_REFRESH_BEEP;
    const std::size_t typed = line.size() - word_start(line);
    std::string rest = common_beginning(words);
    rest.erase(0, std::min(typed, rest.size()));
    if (words.size() == 1) rest += ' ';
    if (!rest.empty()) {
      el_insertstr(editor, rest.c_str());
      return CC_REFRESH;
    }
    std::fputc('\n', stdout);
    for (const std::string& word : words) std::fprintf(stdout, "%s  ", word.c_str());
    std::fputc('\n', stdout);
    return CC_REDISPLAY;
  }

  const int end_;
  const std::string file_;
  const CommandTable commands_;
  client::Session& session_;
  History* const history_;
  EditLine* const editor_;
};

// NOLINTEND(*-vararg)

/// Reads lines from standard input; on a terminal with prompt, editing, history and completion.
class LineReader {
 public:
  /// @param commands, session complete words; must outlive this object
  LineReader(CommandTable commands, client::Session& session) : end_(eventfd(0, EFD_CLOEXEC)) {
    if (isatty(STDIN_FILENO) != 1) return;
    editor_ = std::make_unique<Editor>(end_.get(), commands, session);
  }

  /// @return whether a person is at a terminal.
  [[nodiscard]] bool is_interactive() const noexcept { return editor_ != nullptr; }

  /// @return the next line without its end; nothing at the end of the input and after end().
  std::optional<std::string> next() { return editor_ ? editor_->next() : next_of_pipe(); }

  /// Ends the wait for a line, and every later one. Thread-safe.
  void end() noexcept {
    const std::uint64_t one = 1;
    // It can fail only if the event is already set.
    [[maybe_unused]] const ssize_t written = write(end_.get(), &one, sizeof one);
  }

 private:
  std::optional<std::string> next_of_pipe() {
    constexpr std::size_t kBlock = 4096;
    std::size_t end = ahead_.find('\n');
    while (end == std::string::npos) {
      std::array<char, kBlock> block{};
      const bool has_input = wait_for_input(end_.get());
      const ssize_t count = has_input ? read(STDIN_FILENO, block.data(), block.size()) : 0;
      if (!has_input || (count <= 0 && ahead_.empty())) return std::nullopt;
      if (count <= 0) return std::exchange(ahead_, {});
      const std::size_t searched = ahead_.size();
      ahead_.append(block.data(), static_cast<std::size_t>(count));
      end = ahead_.find('\n', searched);
      // Of a line that is too long, keeps just enough for it to be refused.
      if (end == std::string::npos && ahead_.size() > kLongestLine) ahead_.resize(kLongestLine + 1);
    }
    std::string line = ahead_.substr(0, end);
    ahead_.erase(0, end + 1);
    return line;
  }

  process::Descriptor end_;
  std::unique_ptr<Editor> editor_;  ///< nullptr if standard input is not a terminal
  std::string ahead_;
};

/// Reads commands from standard input and executes them in one session, until the end of the input,
/// `exit` or `quit`. A failure does not end the shell; Ctrl-C ends the running command. `help`
/// shows the commands, `help COMMAND` one. SIGTERM, SIGHUP and, without a terminal, Ctrl-C between
/// two commands end it.
class Shell {
 public:
  Shell(const Program& program, client::Session& session, Interrupt& interrupt)
      : program_(program),
        session_(session),
        interrupt_(interrupt),
        terminal_(program.terminal),
        context_(session, {program.terminal, program.options.json, false}, program.commands),
        reader_(program.commands, session) {
    context_.outlives_failures = true;
  }

  /// @return interrupted if a signal has ended it; otherwise ok on a terminal, and without one the
  ///         exit code of the first failed command.
  ExitCode run() {
    interrupt_.arm([this] {
      session_.interrupt();
      // On a terminal, Ctrl-C only drops the line, even if the terminal is still in its own editing
      // mode and sends Ctrl-C as a signal.
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
    // Between two lines there is no command for a signal to end, so it ends the shell.
    if (!reader_.is_interactive() && interrupt_.happened()) end_by_signal();
    auto line = reader_.next();
    is_waiting_ = false;
    if (is_ended_by_signal_) line.reset();  // the reader may have buffered lines
    return line;
  }

  /// @return whether a signal has arrived since the last call. Without a terminal it also ends the
  ///         shell: a user who interrupts a file of commands does not want the rest of it.
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
      // An interrupted command needs no explanation.
      const bool is_told = !outcome && !interrupt_.happened();
      if (is_told) terminal_.print_error("vdrive: " + outcome.message());
      code = exit_code_of(outcome.kind());
    } catch (const UsageError& error) {
      code = report_usage(error.what(), program_.options.json, terminal_);
    } catch (const std::exception& error) {
      terminal_.print_error(std::string("vdrive: ") + error.what());
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

constexpr std::string_view kShellHelp =
    R"(Commands are those of a scenario, and watch, events, record, plot and run, without 'vdrive'. The
session keeps the axes that it commands until the shell ends: at 'exit', 'quit', Ctrl-D or the end of
the input. 'help' lists the commands, 'help move' explains one. Tab completes, the arrow keys find
earlier lines, Ctrl-C ends the command that runs.

Example:
  vdrive shell
  vdrive shell < commands.txt)";

struct ShellCommand {
  void declare(Arguments& /*arguments*/) {}

  static ExitCode start(const Program& program) {
    Interrupt interrupt;
    interrupt.before_exit([&program] {
      program.terminal.leave_screen_at_once();
    });
    client::Session session(session_options(program.options));
    return Shell(program, session, interrupt).run();
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
