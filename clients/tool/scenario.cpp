// SPDX-License-Identifier: Apache-2.0
#include "scenario.hpp"

#include "blanks.hpp"
#include "grammar.hpp"
#include "scenario_check.hpp"
#include "usage_error.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <istream>
#include <utility>

namespace vdrive::tool {
namespace {

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

/// Reads a scenario line by line.
class ScenarioReader {
 public:
  ScenarioReader(std::string file, const Variables::Values& settings)
      : scenario_{std::move(file), {}, {}}, variables_(settings) {}

  void take(std::size_t number, std::string_view line) {
    if (number == 1 && is_wide_text(line)) {
      throw UsageError(escaped(scenario_.file, kShownOfMessage) +
                       ": is encoded in UTF-16 or UTF-32; it must be UTF-8");
    }
    if (number == 1 && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
    try {
      take_line(number, line.substr(0, comment_start(line)));
    } catch (const UsageError& error) {
      throw UsageError(escaped(scenario_.file, kShownOfMessage) + ":" + std::to_string(number) +
                       ": " + error.what());
    }
  }

  Scenario finish() && {
    scenario_.variables = variables_.names();
    return std::move(scenario_);
  }

 private:
  void take_line(std::size_t number, std::string_view line) {
    const std::string text = variables_.expand(line);
    if (variables_.let(text)) return;
    std::vector<std::string> words = split_words(text);
    if (words.empty()) return;
    if (words.front() == "finally") {
      begin_final(words);
      return;
    }
    ScenarioCommand parsed = parse_scenario_command(std::move(words));
    check_objects(parsed.command);
    scenario_.lines.push_back({.number = number,
                               .text = std::string(trimmed(text)),
                               .command = std::move(parsed.command),
                               .timeout = parsed.timeout,
                               .is_final = is_final_});
  }

  void begin_final(const std::vector<std::string>& words) {
    if (words.size() > 1) {
      throw UsageError(in_quotes(words[1]) + " is one argument too many: finally has no arguments");
    }
    if (is_final_) throw UsageError("the file has another finally above");
    is_final_ = true;
  }

  Scenario scenario_;
  Variables variables_;
  bool is_final_ = false;
};

Scenario load(const std::string& name, const Variables::Values& settings) {
  if (name == "-") return parse_scenario(std::cin, name_of_scenario(name), settings);
  std::ifstream file(name);
  // A directory opens, but has no bytes.
  if (!file || std::filesystem::is_directory(name)) {
    throw UsageError("cannot read " + in_quotes(name));
  }
  return parse_scenario(file, name, settings);
}

std::string unused_variable(const std::string& name, const std::vector<Scenario>& scenarios) {
  std::vector<std::string> known;
  for (const Scenario& scenario : scenarios) {
    known.insert(known.end(), scenario.variables.begin(), scenario.variables.end());
  }
  return "--set: no file has a variable " + in_quotes(name) + suggestion(name, known);
}

}  // namespace

std::vector<std::string> split_words(std::string_view line) {
  WordSplitter splitter;
  for (const char c : line.substr(0, comment_start(line))) splitter.take(c);
  return std::move(splitter).finish();
}

Scenario parse_scenario(std::istream& input, const std::string& file,
                        const Variables::Values& settings) {
  ScenarioReader reader(file, settings);
  std::string text;
  for (std::size_t number = 1; std::getline(input, text); ++number) reader.take(number, text);
  return std::move(reader).finish();
}

std::string name_of_scenario(const std::string& file) {
  return file == "-" ? "<stdin>" : file;
}

std::vector<Scenario> load_scenarios(const std::vector<std::string>& names,
                                     const Variables::Values& settings) {
  std::vector<Scenario> scenarios;
  scenarios.reserve(names.size());
  for (const std::string& name : names) scenarios.push_back(load(name, settings));
  for (const auto& [variable, value] : settings) {
    const bool is_used = std::ranges::any_of(scenarios, [&name = variable](const Scenario& one) {
      return one.variables.contains(name);
    });
    if (!is_used) throw UsageError(unused_variable(variable, scenarios));
  }
  return scenarios;
}

}  // namespace vdrive::tool
