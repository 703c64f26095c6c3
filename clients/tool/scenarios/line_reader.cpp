// SPDX-License-Identifier: Apache-2.0
#include "scenarios/line_reader.hpp"

#include "language/scenario_limits.hpp"

#include <histedit.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <clocale>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cwchar>
#include <filesystem>
#include <string_view>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr int kKeptLines = 1000;

/// Waits for standard input. @return false when `end` is readable.
bool wait_for_input(int end) {
  std::array<pollfd, 2> ready{pollfd{STDIN_FILENO, POLLIN, 0}, pollfd{end, POLLIN, 0}};
  while (poll(ready.data(), ready.size(), -1) < 0) {
  }
  return ready[1].revents == 0;
}

/// @return what all of them begin with.
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

}  // namespace

/// libedit. Its interface takes variable arguments, and has callbacks without our object in their
/// arguments: that is the client data of the editor.
// NOLINTBEGIN(*-vararg)
class LineReader::Editor {
 public:
  Editor(int end, std::string file, Completer completer)
      : end_(end),
        file_(std::move(file)),
        completer_(std::move(completer)),
        history_(history_init()),
        editor_(el_init("vdrive", stdin, stdout, stderr)) {
    // It reads multi-byte characters by the encoding of the locale.
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
    // While a line is edited Ctrl-C is a character: it drops the line.
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
    // By itself the editor shows its prompt first. What is typed in between would be edited by the
    // terminal, and Ctrl-C a signal that no thread waits for.
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

  /// @return 1, 0 at the end, as read() does.
  static int read_character(EditLine* editor, wchar_t* character) {
    std::mbstate_t state{};
    while (true) {
      char byte = 0;
      if (!wait_for_input(of(editor).end_) || read(STDIN_FILENO, &byte, 1) != 1) return 0;
      // NOLINTNEXTLINE(concurrency-mt-unsafe): the state is our own
      const std::size_t length = std::mbrtowc(character, &byte, 1, &state);
      if (length <= 1) return 1;
      // Not a character of this locale: what came is dropped.
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
    const std::vector<std::string> words = of(editor).completer_(line);
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
  const Completer completer_;
  History* const history_;
  EditLine* const editor_;
};

// NOLINTEND(*-vararg)

LineReader::LineReader(const std::string& history, Completer completer)
    : end_(eventfd(0, EFD_CLOEXEC)) {
  if (isatty(STDIN_FILENO) != 1) return;
  editor_ = std::make_unique<Editor>(end_.get(), history, std::move(completer));
}

LineReader::~LineReader() = default;

bool LineReader::is_interactive() const noexcept {
  return editor_ != nullptr;
}

std::optional<std::string> LineReader::next() {
  return editor_ ? editor_->next() : next_of_pipe();
}

std::optional<std::string> LineReader::next_of_pipe() {
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
    // Of a line that is too long enough is kept to refuse it.
    if (end == std::string::npos && ahead_.size() > kLongestLine) ahead_.resize(kLongestLine + 1);
  }
  std::string line = ahead_.substr(0, end);
  ahead_.erase(0, end + 1);
  return line;
}

void LineReader::end() noexcept {
  const std::uint64_t one = 1;
  // It can fail only when it is readable already.
  [[maybe_unused]] const ssize_t written = write(end_.get(), &one, sizeof one);
}

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

}  // namespace vdrive::tool
