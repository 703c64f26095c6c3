// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// A colour of the terminal, with its number in escape sequences.
enum class Color : int { green = 32, red = 31, yellow = 33, cyan = 36, bold = 1 };

/// A row of a display that is refreshed in place.
struct LiveLine {
  std::string text;  ///< without escape sequences
  std::optional<Color> color;

  friend bool operator==(const LiveLine&, const LiveLine&) = default;
};

/// The size of a terminal.
struct TerminalSize {
  std::size_t columns = 100;
  std::size_t rows = 24;

  friend bool operator==(const TerminalSize&, const TerminalSize&) = default;
};

/// Standard output and standard error, shared by the commands and a live view. Lines are never
/// mixed: a live block at the end of the terminal, and the progress line below it, are erased
/// before a line is printed and redrawn after it. Rows refreshed in place are clipped to the
/// present width of the terminal, because a wrapped row could not be refreshed. Thread-safe.
class Terminal {
 public:
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// @return whether standard output is a terminal that can be refreshed in place: TERM is neither
  ///         unset nor "dumb".
  [[nodiscard]] bool is_interactive() const noexcept { return is_interactive_; }

  /// @return whether a person reads standard error, because it is a terminal.
  [[nodiscard]] bool is_read_by_person() const noexcept { return is_read_by_person_; }

  /// @return whether colours may be used: interactive, and NO_COLOR unset.
  [[nodiscard]] bool has_color() const noexcept { return has_color_; }

  /// @return whether standard error is a terminal that can be refreshed in place.
  [[nodiscard]] bool shows_progress() const noexcept { return shows_progress_; }

  /// Prints a line on standard output.
  void print(std::string_view line);

  /// Prints a line on standard error.
  void print_error(std::string_view line);

  /// Replaces the live block below the last line, on a terminal only. If the block is higher than
  /// the terminal, its last row shows the number of omitted rows.
  void show_live(std::vector<LiveLine> lines);

  /// Replaces the screen, on a terminal only: uses the alternate screen until end_live().
  void show_screen(std::vector<LiveLine> lines);

  /// Replaces the progress line, which is always last, on standard error and on a terminal only.
  void show_progress(std::string line);

  /// Removes the progress line.
  void end_progress() { show_progress({}); }

  /// Leaves the last block on the terminal as lines, and starts a new block below.
  void end_live();

  /// Leaves the alternate screen and erases the progress line, without a lock, immediately before
  /// the process ends.
  void leave_screen_at_once() noexcept;

  /// @return false once writing to standard output has failed: either its reader has gone, or
  ///         write_failure() has the reason.
  [[nodiscard]] bool is_open() const;

  /// @return why a line is missing on standard output; nothing if none is missing, or if one is
  ///         missing only because the reader of the pipe has gone.
  [[nodiscard]] std::optional<std::string> write_failure() const;

 private:
  void erase_progress();
  void draw_progress();
  void erase_live();
  void draw_live();
  void leave_screen();
  void put(std::string_view text);
  void flush();
  void note_failure();
  [[nodiscard]] std::string row_of(const LiveLine& line, std::size_t width) const;

  const bool is_interactive_;
  const bool has_color_;
  const bool is_read_by_person_;
  const bool shows_progress_;
  mutable std::mutex mutex_;
  std::vector<LiveLine> live_;
  std::size_t live_rows_ = 0;  ///< drawn below the last line
  std::vector<LiveLine> screen_;
  std::string progress_;  ///< empty = none
  std::atomic<bool> is_progress_drawn_ = false;
  std::atomic<bool> is_on_screen_ = false;
  int write_error_ = 0;  ///< errno, 0 = none
};

/// @return the present size of the terminal on standard output; the default if unknown.
[[nodiscard]] TerminalSize terminal_size();

/// @return `text` in this colour, or unchanged.
[[nodiscard]] std::string colored(const Terminal& terminal, Color color, std::string_view text);

}  // namespace vdrive::tool
