// SPDX-License-Identifier: Apache-2.0
#include "tool/screen.hpp"

#include <algorithm>
#include <array>

namespace vdrive::test {

Screen::Screen(std::size_t rows, std::size_t columns) : rows_(rows), columns_(columns) {
  resize(rows, columns);
}

void Screen::resize(std::size_t rows, std::size_t columns) {
  rows_ = rows;
  columns_ = columns;
  for (Grid* const grid : {&main_, &alternate_}) {
    grid->cells.resize(rows);
    for (auto& row : grid->cells) row.resize(columns);
    grid->row = std::min(grid->row, rows - 1);
    grid->column = std::min(grid->column, columns);
  }
}

void Screen::take(std::string_view bytes) {
  for (const char c : bytes) {
    if (!sequence_.empty()) {
      sequence_ += c;
      const bool is_final = sequence_.size() > 2 && c >= '@' && c <= '~';
      const bool is_no_control_sequence = sequence_.size() == 2 && c != '[';
      if (is_final || is_no_control_sequence) {
        apply(sequence_);
        sequence_.clear();
      }
    } else if (c == '\x1b') {
      sequence_ = c;
    } else if (c == '\r') {
      grid().column = 0;
    } else if (c == '\n') {
      feed_line();
    } else if ((static_cast<unsigned char>(c) & 0xC0U) != 0x80U) {  // not a UTF-8 continuation byte
      put(c);
    }
  }
}

void Screen::put(char c) {
  if (grid().column >= columns_) {
    ++wrapped_;
    grid().column = 0;
    feed_line();
  }
  grid().cells[grid().row][grid().column++] = {c, color_};
}

void Screen::feed_line() {
  Grid& shown = grid();
  if (shown.row + 1 < rows_) {
    ++shown.row;
    return;
  }
  ++scrolled_;
  shown.cells.erase(shown.cells.begin());
  shown.cells.emplace_back(columns_);
}

void Screen::erase(std::size_t row, std::size_t from) {
  auto& cells = grid().cells[row];
  for (std::size_t column = from; column < cells.size(); ++column) cells[column] = {};
}

void Screen::apply(const std::string& sequence) {
  Grid& shown = grid();
  const std::string body = sequence.substr(2, sequence.size() - 3);
  switch (sequence.back()) {
    case 'H':
      shown.row = 0;
      shown.column = 0;
      break;
    case 'A':
      shown.row -= std::min<std::size_t>(shown.row, std::stoul(body));
      break;
    case 'K':
      erase(shown.row, body == "2" ? 0 : shown.column);
      break;
    case 'J':
      erase(shown.row, shown.column);
      for (std::size_t row = shown.row + 1; row < rows_; ++row) erase(row, 0);
      break;
    case 'm':
      color_ = std::stoi(body);
      break;
    case 'h':
    case 'l':
      set_mode(body, sequence.back() == 'h');
      break;
    default:
      break;
  }
  // All sequences that the tool sends.
  constexpr std::array<std::string_view, 15> kKnown{"[H",   "[1A",     "[K",      "[2K",   "[J",
                                                    "[0m",  "[1m",     "[31m",    "[32m",  "[33m",
                                                    "[36m", "[?1049h", "[?1049l", "[?25h", "[?25l"};
  const std::string name = sequence.substr(1);
  if (std::ranges::find(kKnown, name) == kKnown.end()) unknown_.push_back(name);
}

void Screen::set_mode(const std::string& mode, bool on) {
  if (mode == "?25") {
    shows_cursor_ = on;
  } else if (mode == "?1049") {
    is_alternate_ = on;
    if (on) alternate_ = {};
    resize(rows_, columns_);
  }
}

std::vector<std::string> Screen::rows() const {
  std::vector<std::string> rows;
  for (const auto& cells : grid().cells) {
    std::string& row = rows.emplace_back();
    for (const Cell& cell : cells) row += cell.character;
    row.erase(row.find_last_not_of(' ') + 1);
  }
  return rows;
}

int Screen::color_of_row(std::size_t row) const {
  return grid().cells.at(row).front().color;
}

}  // namespace vdrive::test
