// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::test {

/// A model of a terminal. It wraps lines at the right edge and scrolls at the bottom as xterm does,
/// knows the escape sequences of the tool, and records all others. A resize crops rows or adds
/// blanks; it does not rewrap.
class Screen {
 public:
  Screen(std::size_t rows, std::size_t columns);

  /// Processes output of the program. Every character takes one cell.
  void take(std::string_view bytes);

  void resize(std::size_t rows, std::size_t columns);

  /// @return the text of each row without trailing blanks.
  [[nodiscard]] std::vector<std::string> rows() const;

  /// @return the SGR colour at the beginning of the row; 0 = none.
  [[nodiscard]] int color_of_row(std::size_t row) const;

  /// @return whether the alternate screen is shown.
  [[nodiscard]] bool is_alternate() const noexcept { return is_alternate_; }

  [[nodiscard]] bool shows_cursor() const noexcept { return shows_cursor_; }

  /// The number of rows that scrolled off the top of the current screen, and of lines that were too
  /// long and wrapped.
  [[nodiscard]] std::size_t scrolled() const noexcept { return scrolled_; }

  [[nodiscard]] std::size_t wrapped() const noexcept { return wrapped_; }

  /// Escape sequences unknown to the model.
  [[nodiscard]] const std::vector<std::string>& unknown() const noexcept { return unknown_; }

 private:
  struct Cell {
    char character = ' ';
    int color = 0;
  };

  struct Grid {
    std::vector<std::vector<Cell>> cells;
    std::size_t row = 0;
    std::size_t column = 0;
  };

  void put(char c);
  void feed_line();
  void apply(const std::string& sequence);
  void set_mode(const std::string& mode, bool on);
  void erase(std::size_t row, std::size_t from);

  Grid& grid() { return is_alternate_ ? alternate_ : main_; }

  [[nodiscard]] const Grid& grid() const { return is_alternate_ ? alternate_ : main_; }

  std::size_t rows_;
  std::size_t columns_;
  Grid main_;
  Grid alternate_;
  std::string sequence_;  ///< received so far
  int color_ = 0;
  bool is_alternate_ = false;
  bool shows_cursor_ = true;
  std::size_t scrolled_ = 0;
  std::size_t wrapped_ = 0;
  std::vector<std::string> unknown_;
};

}  // namespace vdrive::test
