// SPDX-License-Identifier: Apache-2.0
#include "terminal/terminal.hpp"

#include "terminal/columns.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <system_error>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr std::string_view kEnterScreen = "\x1b[?1049h\x1b[?25l";  // and hide the cursor
constexpr std::string_view kLeaveScreen = "\x1b[?25h\x1b[?1049l";
// Row by row, then the rest below: clearing the screen first would flicker.
constexpr std::string_view kCursorHome = "\x1b[H";
constexpr std::string_view kEraseRight = "\x1b[K";
constexpr std::string_view kEraseBelow = "\x1b[J";
constexpr std::string_view kEraseRow = "\r\x1b[K";
constexpr std::string_view kEraseRowAbove = "\x1b[1A\x1b[2K";

/// Read once at the start, before there are other threads.
std::string_view environment(const char* name) {
  const char* const value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value == nullptr ? std::string_view() : value;
}

/// @param stream STDOUT_FILENO or STDERR_FILENO
bool can_refresh(int stream) {
  const std::string_view kind = environment("TERM");
  return isatty(stream) == 1 && !kind.empty() && kind != "dumb";
}

TerminalSize room_on(int stream) {
  winsize size{};
  // The only interface there is takes variable arguments.
  const bool known = ioctl(stream, TIOCGWINSZ, &size) == 0;  // NOLINT(*-vararg)
  TerminalSize room;
  if (known && size.ws_col > 1) room.columns = size.ws_col;
  if (known && size.ws_row > 0) room.rows = size.ws_row;
  return room;
}

/// A failure to write to standard error cannot be reported to anyone.
void put_error(std::string_view text) {
  (void)std::fwrite(text.data(), 1, text.size(), stderr);
}

std::string in_color(Color color, std::string_view text) {
  return "\x1b[" + std::to_string(static_cast<int>(color)) + "m" + std::string(text) + "\x1b[0m";
}

/// One less than the width: after a row that fills the last column, terminals differ in the
/// position of the cursor.
std::size_t usable_width(const TerminalSize& size) {
  return size.columns - 1;
}

/// @return at most `rows` lines; if some are omitted, the last one has their number.
std::vector<LiveLine> fitting(const std::vector<LiveLine>& lines, std::size_t rows) {
  if (lines.size() <= rows) return lines;
  const std::size_t shown = std::max<std::size_t>(rows, 1) - 1;
  std::vector<LiveLine> some(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(shown));
  some.push_back({"... " + std::to_string(lines.size() - shown) + " more rows", std::nullopt});
  return some;
}

}  // namespace

Terminal::Terminal()
    : is_interactive_(can_refresh(STDOUT_FILENO)),
      has_color_(is_interactive_ && environment("NO_COLOR").empty()),
      is_read_by_person_(isatty(STDERR_FILENO) == 1),
      shows_progress_(can_refresh(STDERR_FILENO)) {}

Terminal::~Terminal() {
  leave_screen();
}

void Terminal::print(std::string_view line) {
  const std::scoped_lock lock(mutex_);
  erase_progress();
  leave_screen();
  erase_live();
  put(line);
  put("\n");
  draw_live();
  flush();
  draw_progress();
}

void Terminal::print_error(std::string_view line) {
  const std::scoped_lock lock(mutex_);
  erase_progress();
  leave_screen();
  erase_live();
  flush();
  put_error(line);
  put_error("\n");
  (void)std::fflush(stderr);
  draw_live();
  draw_progress();
}

void Terminal::show_live(std::vector<LiveLine> lines) {
  if (!is_interactive_) return;
  const std::scoped_lock lock(mutex_);
  erase_progress();
  erase_live();
  live_ = std::move(lines);
  draw_live();
  flush();
  draw_progress();
}

void Terminal::show_progress(std::string line) {
  if (!shows_progress_) return;
  const std::scoped_lock lock(mutex_);
  erase_progress();
  progress_ = std::move(line);
  draw_progress();
}

void Terminal::show_screen(std::vector<LiveLine> lines) {
  if (!is_interactive_) return;
  const std::scoped_lock lock(mutex_);
  const TerminalSize size = terminal_size();
  screen_ = std::move(lines);
  std::string frame(is_on_screen_.exchange(true) ? std::string_view() : kEnterScreen);
  frame += kCursorHome;
  std::string_view line_end;
  for (const LiveLine& line : fitting(screen_, size.rows)) {
    frame.append(line_end).append(row_of(line, usable_width(size))).append(kEraseRight);
    line_end = "\r\n";
  }
  put(frame.append(kEraseBelow));
  flush();
}

void Terminal::end_live() {
  const std::scoped_lock lock(mutex_);
  erase_progress();
  live_.clear();
  live_rows_ = 0;
  leave_screen();
  const std::size_t width = usable_width(terminal_size());
  for (const LiveLine& line : std::exchange(screen_, {})) put(row_of(line, width) + "\n");
  flush();
  draw_progress();
}

bool Terminal::is_open() const {
  const std::scoped_lock lock(mutex_);
  return write_error_ == 0;
}

std::optional<std::string> Terminal::write_failure() const {
  const std::scoped_lock lock(mutex_);
  // The reader of a pipe has gone: that ends the stream and is not an error.
  if (write_error_ == 0 || write_error_ == EPIPE) return std::nullopt;
  return "standard output could not be written: " + std::system_category().message(write_error_);
}

void Terminal::put(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) note_failure();
}

void Terminal::flush() {
  if (std::fflush(stdout) != 0) note_failure();
}

/// Keeps the first failure; later ones may follow from it.
void Terminal::note_failure() {
  if (write_error_ == 0) write_error_ = errno;
}

void Terminal::erase_progress() {
  if (!is_progress_drawn_.exchange(false)) return;
  put_error(kEraseRow);
  (void)std::fflush(stderr);
}

void Terminal::draw_progress() {
  if (progress_.empty() || is_on_screen_) return;
  is_progress_drawn_ = true;
  put_error(clipped(progress_, usable_width(room_on(STDERR_FILENO))));
  (void)std::fflush(stderr);
}

/// The number of rows was correct for the terminal size when they were drawn. If the terminal has
/// become narrower since and has wrapped them, some rows remain: that is better than erasing lines
/// that are not ours.
void Terminal::erase_live() {
  for (; live_rows_ > 0; --live_rows_) put(kEraseRowAbove);
}

void Terminal::draw_live() {
  const TerminalSize size = terminal_size();
  // The cursor is below the block.
  const std::vector<LiveLine> lines = fitting(live_, std::max<std::size_t>(size.rows, 2) - 1);
  for (const LiveLine& line : lines) put(row_of(line, usable_width(size)) + "\n");
  live_rows_ = lines.size();
}

void Terminal::leave_screen() {
  if (!is_on_screen_.exchange(false)) return;
  put(kLeaveScreen);
  flush();
}

void Terminal::leave_screen_at_once() noexcept {
  const auto put_at_once = [](int stream, std::string_view sequence) {
    // A failure cannot be handled any more.
    [[maybe_unused]] const ssize_t written = write(stream, sequence.data(), sequence.size());
  };
  if (is_progress_drawn_.exchange(false)) put_at_once(STDERR_FILENO, kEraseRow);
  if (is_on_screen_.exchange(false)) put_at_once(STDOUT_FILENO, kLeaveScreen);
}

std::string Terminal::row_of(const LiveLine& line, std::size_t width) const {
  std::string row = clipped(line.text, width);
  return line.color && has_color_ ? in_color(*line.color, row) : row;
}

TerminalSize terminal_size() {
  return room_on(STDOUT_FILENO);
}

std::string colored(const Terminal& terminal, Color color, std::string_view text) {
  return terminal.has_color() ? in_color(color, text) : std::string(text);
}

}  // namespace vdrive::tool
