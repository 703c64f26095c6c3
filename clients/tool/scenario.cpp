// SPDX-License-Identifier: Apache-2.0
#include "scenario.hpp"

#include "grammar.hpp"
#include "scenario_check.hpp"
#include "usage_error.hpp"
#include "vdrive/text.hpp"

#include <istream>

namespace vdrive::tool {
namespace {

constexpr std::string_view kBlanks = " \t\r\f\v";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// @return where the comment starts, or the end.
std::size_t comment_start(std::string_view line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote != 0) {
      if (line[i] == quote) quote = 0;
    } else if (line[i] == '\'' || line[i] == '"') {
      quote = line[i];
    } else if (line[i] == '#') {
      return i;
    }
  }
  return line.size();
}

/// Takes a line character by character; blanks part words, quotes hold them together.
class WordSplitter {
 public:
  void take(char c) {
    if (quote_ != 0 && c == quote_) {
      quote_ = 0;
    } else if (quote_ == 0 && (c == '\'' || c == '"')) {
      quote_ = c;
      is_in_word_ = true;
    } else if (quote_ == 0 && kBlanks.find(c) != std::string_view::npos) {
      end_word();
    } else {
      word_ += c;
      is_in_word_ = true;
    }
  }

  std::vector<std::string> finish() && {
    if (quote_ != 0) throw UsageError(std::string("no closing ") + quote_);
    end_word();
    return std::move(words_);
  }

 private:
  void end_word() {
    if (is_in_word_) words_.push_back(std::exchange(word_, {}));
    is_in_word_ = false;
  }

  std::vector<std::string> words_;
  std::string word_;
  bool is_in_word_ = false;
  char quote_ = 0;
};

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace

std::vector<std::string> split_words(std::string_view line) {
  WordSplitter splitter;
  for (const char c : line.substr(0, comment_start(line))) splitter.take(c);
  return std::move(splitter).finish();
}

Scenario parse_scenario(std::istream& input, const std::string& file) {
  Scenario scenario{file, {}};
  std::string text;
  for (std::size_t number = 1; std::getline(input, text); ++number) {
    std::string_view line = text;
    if (number == 1 && is_wide_text(line)) {
      throw UsageError(escaped(file, kShownOfMessage) +
                       ": is encoded in UTF-16 or UTF-32; it must be UTF-8");
    }
    if (number == 1 && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
    try {
      std::vector<std::string> words = split_words(line);
      if (words.empty()) continue;
      ScenarioWords parsed = parse_scenario_words(std::move(words));
      check_objects(parsed.command);
      scenario.lines.push_back({.number = number,
                                .text = std::string(trimmed(line.substr(0, comment_start(line)))),
                                .command = std::move(parsed.command),
                                .timeout = parsed.timeout});
    } catch (const UsageError& error) {
      throw UsageError(escaped(file, kShownOfMessage) + ":" + std::to_string(number) + ": " +
                       error.what());
    }
  }
  return scenario;
}

}  // namespace vdrive::tool
