// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// Standard output and standard error, shared by the commands and a live view. Lines are whole:
/// a live block at the end of the terminal is taken away before a line and drawn again after it.
/// Thread-safe.
class Terminal {
 public:
  Terminal();

  /// @return whether standard output is a terminal.
  [[nodiscard]] bool is_interactive() const noexcept { return is_interactive_; }

  /// @return whether colours may be used: a terminal, and NO_COLOR unset.
  [[nodiscard]] bool has_color() const noexcept { return has_color_; }

  /// One line on standard output.
  void print(std::string_view line);

  /// One line on standard error.
  void complain(std::string_view line);

  /// Replaces the live block, on a terminal only.
  void show_live(std::vector<std::string> lines);

  /// Leaves the live block as it is and starts a new one below.
  void end_live();

  /// @return false once the reader of standard output has gone away.
  [[nodiscard]] bool is_open() const;

 private:
  void erase_live();
  void draw_live();

  const bool is_interactive_;
  const bool has_color_;
  mutable std::mutex mutex_;
  std::vector<std::string> live_;
  bool is_open_ = true;
};

/// @return the width of the terminal [columns], 100 when unknown.
[[nodiscard]] std::size_t terminal_width();

/// A colour of the terminal, as its escape sequence takes it.
enum class Color : int { green = 32, red = 31, yellow = 33, cyan = 36, bold = 1 };

/// @return `text` in this colour, or as it is.
[[nodiscard]] std::string colored(const Terminal& terminal, Color color, std::string_view text);

}  // namespace vdrive::tool
