// SPDX-License-Identifier: Apache-2.0
#include "language/variables.hpp"

#include "base/blanks.hpp"
#include "base/usage_error.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::tool {
namespace {

// Values are inserted literally, and these would change how the line is parsed.
constexpr std::string_view kNotInValues = "\"'#${}";

bool is_name(std::string_view text) {
  const auto is_name_character = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !text.empty() && (text[0] < '0' || text[0] > '9') &&
         std::ranges::all_of(text, is_name_character);
}

void check_name(std::string_view name) {
  if (is_name(name)) return;
  throw UsageError(in_quotes(name) +
                   " is not a name of a variable: write letters, digits and _, no digit first");
}

void check_value(std::string_view name, std::string_view value) {
  if (value.empty()) throw UsageError("the variable " + in_quotes(name) + " has no value");
  const bool is_plain = std::ranges::none_of(value, [](char c) {
    return kNotInValues.find(c) != std::string_view::npos || static_cast<unsigned char>(c) < 0x20;
  });
  if (is_plain) return;
  throw UsageError("the value " + in_quotes(value) + " of the variable " + in_quotes(name) +
                   " must not contain \", ', #, $, {, } or control characters");
}

/// Splits `NAME = VALUE`.
std::pair<std::string, std::string> parted(std::string_view text, std::string_view example) {
  const std::size_t sign = text.find('=');
  if (sign == std::string_view::npos) {
    throw UsageError(in_quotes(text) + " has no =: write for example " + std::string(example));
  }
  const std::string_view name = trimmed(text.substr(0, sign));
  const std::string_view value = trimmed(text.substr(sign + 1));
  check_name(name);
  check_value(name, value);
  return {std::string(name), std::string(value)};
}

/// Appends to a line with a limit: values could make `let` lines grow without bound.
void append_bounded(std::string& line, std::string_view text) {
  if (text.size() > kLongestLine - line.size()) {
    throw UsageError("the line has more than " + std::to_string(kLongestLine) +
                     " bytes with the values of its variables, which is the limit");
  }
  line.append(text);
}

}  // namespace

bool Variables::let(std::string_view line) {
  constexpr std::string_view kWord = "let";
  line = trimmed(line);
  if (!line.starts_with(kWord)) return false;
  const std::string_view rest = line.substr(kWord.size());
  if (!rest.empty() && kBlanks.find(rest[0]) == std::string_view::npos) return false;
  auto [name, value] = parted(trimmed(rest), "let speed = 500");
  if (!defaults_.emplace(name, std::move(value)).second) {
    throw UsageError("the variable " + in_quotes(name) + " has a value already");
  }
  names_.insert(std::move(name));
  return true;
}

std::string Variables::expand(std::string_view line) {
  std::string text;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t begin = std::min(line.find("${", at), line.size());
    append_bounded(text, line.substr(at, begin - at));
    if (begin == line.size()) break;
    const std::size_t end = line.find('}', begin);
    if (end == std::string_view::npos) throw UsageError("no } after ${");
    const std::string_view name = line.substr(begin + 2, end - begin - 2);
    check_name(name);
    append_bounded(text, value_of(std::string(name)));
    at = end + 1;
  }
  return text;
}

const std::string& Variables::value_of(const std::string& name) {
  names_.insert(name);
  if (const auto set = settings_.find(name); set != settings_.end()) return set->second;
  if (const auto given = defaults_.find(name); given != defaults_.end()) return given->second;
  std::vector<std::string> known;
  known.reserve(defaults_.size() + settings_.size());
  for (const auto& [other, value] : defaults_) known.push_back(other);
  for (const auto& [other, value] : settings_) known.push_back(other);
  throw UsageError("the variable " + in_quotes(name) + " has no value" + suggestion(name, known) +
                   "; write 'let " + name + " = VALUE' above, or call with --set " + name +
                   "=VALUE");
}

Variables::Values settings_of(const std::vector<std::string>& texts) {
  Variables::Values settings;
  for (const std::string& text : texts) {
    auto [name, value] = parted(text, "--set axis=7.1");
    if (!settings.emplace(name, std::move(value)).second) {
      throw UsageError("--set: the variable " + in_quotes(name) + " is set twice");
    }
  }
  return settings;
}

}  // namespace vdrive::tool
