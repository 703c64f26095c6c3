// SPDX-License-Identifier: Apache-2.0
#include "terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace vdrive::tool {
namespace {

bool may_color() {
  // Read once, at the start, before there are threads.
  const char* const no_color = std::getenv("NO_COLOR");  // NOLINT(concurrency-mt-unsafe)
  return no_color == nullptr || *no_color == '\0';
}

void put(std::FILE* stream, std::string_view text) {
  // A failure shows in the stream's state, which is_open() shows.
  (void)std::fwrite(text.data(), 1, text.size(), stream);
}

}  // namespace

Terminal::Terminal()
    : is_interactive_(isatty(STDOUT_FILENO) == 1), has_color_(is_interactive_ && may_color()) {}

void Terminal::print(std::string_view line) {
  const std::scoped_lock lock(mutex_);
  erase_live();
  put(stdout, line);
  put(stdout, "\n");
  draw_live();
  is_open_ = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && is_open_;
}

void Terminal::complain(std::string_view line) {
  const std::scoped_lock lock(mutex_);
  erase_live();
  (void)std::fflush(stdout);
  put(stderr, line);
  put(stderr, "\n");
  (void)std::fflush(stderr);
  draw_live();
}

void Terminal::show_live(std::vector<std::string> lines) {
  if (!is_interactive_) return;
  const std::scoped_lock lock(mutex_);
  erase_live();
  live_ = std::move(lines);
  draw_live();
  is_open_ = std::fflush(stdout) == 0 && is_open_;
}

void Terminal::end_live() {
  const std::scoped_lock lock(mutex_);
  live_.clear();
}

bool Terminal::is_open() const {
  const std::scoped_lock lock(mutex_);
  return is_open_;
}

void Terminal::erase_live() {
  for (std::size_t i = 0; i < live_.size(); ++i) put(stdout, "\x1b[1A\x1b[2K");
}

void Terminal::draw_live() {
  for (const std::string& line : live_) {
    put(stdout, line);
    put(stdout, "\n");
  }
}

std::size_t terminal_width() {
  winsize size{};
  // The only interface there is takes variable arguments.
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0;  // NOLINT(*-vararg)
  return known && size.ws_col > 0 ? size.ws_col : 100;
}

std::string colored(const Terminal& terminal, Color color, std::string_view text) {
  if (!terminal.has_color()) return std::string(text);
  return "\x1b[" + std::to_string(static_cast<int>(color)) + "m" + std::string(text) + "\x1b[0m";
}

}  // namespace vdrive::tool
