// SPDX-License-Identifier: Apache-2.0
#include "terminal/columns.hpp"

#include <algorithm>

namespace vdrive::tool {
namespace {

constexpr std::string_view kCut = "..";

bool continues_character(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

/// The width of the character that begins with `c`.
std::size_t width_of(char c) {
  return static_cast<unsigned char>(c) >= 0xE3U ? 2 : 1;
}

/// @return the longest beginning of `text` that takes at most `width` columns.
std::string_view beginning(std::string_view text, std::size_t width) {
  std::size_t taken = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (continues_character(text[i])) continue;
    taken += width_of(text[i]);
    if (taken > width) return text.substr(0, i);
  }
  return text;
}

}  // namespace

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  for (const char c : text) {
    if (!continues_character(c)) width += width_of(c);
  }
  return width;
}

std::string padded(std::string_view text, std::size_t width) {
  return std::string(text).append(width - std::min(width, display_width(text)), ' ');
}

std::string aligned_right(std::string_view text, std::size_t width) {
  return std::string(width - std::min(width, display_width(text)), ' ').append(text);
}

std::string clipped(std::string_view text, std::size_t width) {
  if (display_width(text) <= width) return std::string(text);
  if (width <= kCut.size()) return std::string(beginning(text, width));
  return std::string(beginning(text, width - kCut.size())).append(kCut);
}

std::vector<std::string> table_lines(const std::vector<std::vector<std::string>>& rows,
                                     std::string_view indent) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], display_width(row[i]));
    }
  }
  std::vector<std::string> lines;
  lines.reserve(rows.size());
  for (const auto& row : rows) {
    std::string& line = lines.emplace_back(indent);
    for (std::size_t i = 0; i < row.size(); ++i) line += padded(row[i], widths[i] + 2);
    line.erase(line.find_last_not_of(' ') + 1);
  }
  return lines;
}

}  // namespace vdrive::tool
