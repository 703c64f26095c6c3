// SPDX-License-Identifier: Apache-2.0
#include "signatures.hpp"

#include <cstddef>

namespace vdrive::python {
namespace {

/// @return the place of the first of these characters outside of brackets and quotes, or npos.
std::size_t find_outside(std::string_view text, std::string_view wanted) {
  int depth = 0;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char character = text[i];
    if (quote != 0) {
      if (character == quote) quote = 0;
    } else if (depth == 0 && wanted.find(character) != std::string_view::npos) {
      return i;
    } else if (character == '\'' || character == '"') {
      quote = character;
    } else if (std::string_view("([{<").find(character) != std::string_view::npos) {
      ++depth;
    } else if (std::string_view(")]}>").find(character) != std::string_view::npos) {
      --depth;
    }
  }
  return std::string_view::npos;
}

std::string_view without_blanks(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

/// @return what stands behind the character at `place`; nothing where there is none.
std::string_view behind(std::string_view text, std::size_t place) {
  if (place == std::string_view::npos) return {};
  return without_blanks(text.substr(place + 1));
}

/// @param text such as "timeout: float = 60.0"
Parameter parameter_of(std::string_view text) {
  const std::size_t equals = find_outside(text, "=");
  const std::string_view declared = text.substr(0, equals);
  const std::size_t colon = find_outside(declared, ":");
  return {.name = without_blanks(declared.substr(0, colon)),
          .type = behind(declared, colon),
          .value = behind(text, equals)};
}

}  // namespace

std::optional<Signature> read_signature(std::string_view text) {
  const std::size_t open = text.find('(');
  if (open == std::string_view::npos) return std::nullopt;
  Signature signature{.name = text.substr(0, open), .parameters = {}};
  std::string_view left = text.substr(open + 1);
  while (true) {
    const std::size_t end = find_outside(left, ",)");
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view parameter = without_blanks(left.substr(0, end));
    if (!parameter.empty()) signature.parameters.push_back(parameter_of(parameter));
    if (left[end] == ')') return signature;
    left = left.substr(end + 1);
  }
}

}  // namespace vdrive::python
