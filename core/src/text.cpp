// SPDX-License-Identifier: Apache-2.0
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>

namespace vdrive {
namespace {

/// Well-formed byte sequences of UTF-8 (RFC 3629, section 4): ranges of the first and second byte,
/// and the number of bytes. Further bytes are 80h to BFh.
struct Utf8Row {
  unsigned char first_lowest;
  unsigned char first_highest;
  unsigned char second_lowest;
  unsigned char second_highest;
  std::size_t length;
};

constexpr std::array<Utf8Row, 9> kUtf8{{
    {0x00, 0x7F, 0x00, 0x00, 1},
    {0xC2, 0xDF, 0x80, 0xBF, 2},
    {0xE0, 0xE0, 0xA0, 0xBF, 3},
    {0xE1, 0xEC, 0x80, 0xBF, 3},
    {0xED, 0xED, 0x80, 0x9F, 3},
    {0xEE, 0xEF, 0x80, 0xBF, 3},
    {0xF0, 0xF0, 0x90, 0xBF, 4},
    {0xF1, 0xF3, 0x80, 0xBF, 4},
    {0xF4, 0xF4, 0x80, 0x8F, 4},
}};

bool is_within(char c, unsigned char lowest, unsigned char highest) noexcept {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= lowest && byte <= highest;
}

/// @return the length of the first character of `text`, or 0 if it is not UTF-8.
std::size_t character_length(std::string_view text) noexcept {
  const auto* const row = std::ranges::find_if(kUtf8, [&](const Utf8Row& candidate) {
    return is_within(text[0], candidate.first_lowest, candidate.first_highest);
  });
  if (row == kUtf8.end() || text.size() < row->length) return 0;
  if (row->length > 1 && !is_within(text[1], row->second_lowest, row->second_highest)) return 0;
  const std::string_view rest =
      text.substr(0, row->length).substr(std::min<std::size_t>(2, row->length));
  const bool continues = std::ranges::all_of(rest, [](char c) {
    return is_within(c, 0x80, 0xBF);
  });
  return continues ? row->length : 0;
}

/// Removes the first character of `text`; a byte that is not UTF-8 counts as one.
std::string_view take_character(std::string_view& text) noexcept {
  const std::string_view character =
      text.substr(0, std::max<std::size_t>(1, character_length(text)));
  text.remove_prefix(character.size());
  return character;
}

std::size_t count_characters(std::string_view text) noexcept {
  std::size_t count = 0;
  for (; !text.empty(); ++count) static_cast<void>(take_character(text));
  return count;
}

/// A multi-byte character that a terminal does not show as a character.
bool is_unprintable(std::string_view character) noexcept {
  if (character.size() == 2) {  // U+0080 to U+009F
    return character[0] == '\xC2' && is_within(character[1], 0x80, 0x9F);
  }
  if (!character.starts_with("\xE2\x80") && !character.starts_with("\xE2\x81")) return false;
  return character[1] == '\x80' ? is_within(character[2], 0xA8, 0xAE)   // U+2028 to U+202E
                                : is_within(character[2], 0xA6, 0xA9);  // U+2066 to U+2069
}

void append_bytes(std::string& out, std::string_view bytes) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    out += "\\x";
    out += kDigits[byte >> 4U];
    out += kDigits[byte & 0xFU];
  }
}

void append_character(std::string& out, std::string_view character) {
  const char first = character[0];
  if (character.size() > 1) {
    if (is_unprintable(character)) {
      append_bytes(out, character);
    } else {
      out += character;
    }
  } else if (first == '\n') {
    out += "\\n";
  } else if (first == '\r') {
    out += "\\r";
  } else if (first == '\t') {
    out += "\\t";
  } else if (first == '\\') {
    out += "\\\\";
  } else if (is_within(first, 0x20, 0x7E)) {
    out += first;
  } else {
    append_bytes(out, character);
  }
}

}  // namespace

std::string escaped(std::string_view text, std::size_t longest) {
  const std::size_t count = count_characters(text);
  const std::size_t tail = count > longest ? longest / 4 : 0;
  const std::size_t head = count > longest ? longest - tail : count;
  std::string out;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view character = take_character(text);
    if (i < head || i >= count - tail) append_character(out, character);
    if (i == head) out += "...";
  }
  return out;
}

std::string in_quotes(std::string_view text) {
  std::string shown(1, '\'');
  shown += escaped(text);
  shown += '\'';
  if (count_characters(text) > kShownOfValue) {
    shown += " (" + std::to_string(text.size()) + " bytes)";
  }
  return shown;
}

std::string joined(const std::vector<std::string>& words, std::string_view separator) {
  std::string text;
  for (const std::string& word : words) {
    if (&word != &words.front()) text += separator;
    text += word;
  }
  return text;
}

bool is_utf8(std::string_view text) noexcept {
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

bool is_wide_text(std::string_view text) noexcept {
  return text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") ||
         text.substr(0, 4).find('\0') != std::string_view::npos;
}

}  // namespace vdrive
