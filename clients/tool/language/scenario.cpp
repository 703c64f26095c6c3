// SPDX-License-Identifier: Apache-2.0
#include "language/scenario.hpp"

#include "base/blanks.hpp"
#include "base/usage_error.hpp"
#include "language/command_line.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <istream>
#include <optional>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// @return the start of the comment, or the end of the line.
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

/// Splits a line, character by character: blanks separate words, quotes keep them together.
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
    if (!std::exchange(is_in_word_, false)) return;
    if (words_.size() == kMostWords) {
      throw UsageError("the line has more than " + std::to_string(kMostWords) +
                       " words, which is the limit");
    }
    words_.push_back(std::exchange(word_, {}));
  }

  std::vector<std::string> words_;
  std::string word_;
  bool is_in_word_ = false;
  char quote_ = 0;
};

void refuse_longer(std::string_view line) {
  if (line.size() <= kLongestLine) return;
  throw UsageError("the line has more than " + std::to_string(kLongestLine) +
                   " bytes, which is the limit");
}

/// Skipped if a refusal is expected: its reason may be that the object does not exist.
void check_objects(const Command& command) {
  if (command.refusal || command.row->check_objects == nullptr) return;
  command.row->check_objects(command.arguments);
}

/// Reads a scenario line by line.
class ScenarioReader {
 public:
  ScenarioReader(CommandTable commands, std::string file, const Variables::Values& settings)
      : commands_(commands), scenario_{std::move(file), {}, {}}, variables_(settings) {}

  /// Reads a line, and records a mistake in it.
  /// @param line may lack its end if it is longer than kLongestLine
  /// @return whether the next line can be read.
  bool take(std::size_t number, std::string_view line) {
    if (number == 1 && is_wide_text(line)) {
      throw UsageError(escaped(scenario_.file, kShownOfMessage) +
                       ": is encoded in UTF-16 or UTF-32; it must be UTF-8");
    }
    if (number == 1 && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
    try {
      check_length(line);
      scenario_.source.append(line).append("\n");
      take_line(number, line.substr(0, comment_start(line)));
    } catch (const UsageError& error) {
      mistakes_.note(escaped(scenario_.file, kShownOfMessage) + ":" + std::to_string(number) +
                     ": " + error.what());
    }
    return !is_too_large_ && !mistakes_.is_full();
  }

  /// Rejects an empty scenario, so that lost content does not pass as a success.
  /// @throws UsageError with each mistake, and for a file that tests nothing.
  Scenario finish() && {
    mistakes_.throw_if_any();
    if (std::ranges::all_of(scenario_.lines, &ScenarioLine::is_final)) {
      throw UsageError(escaped(scenario_.file, kShownOfMessage) +
                       ": has no command: write at least one" +
                       (scenario_.lines.empty() ? "" : " above finally"));
    }
    scenario_.variables = variables_.names();
    return std::move(scenario_);
  }

 private:
  /// The limit of the file includes its comments.
  void check_length(std::string_view line) {
    refuse_longer(line);
    bytes_ += line.size() + 1;
    if (bytes_ > kLargestScenario) refuse_size("");
  }

  [[noreturn]] void refuse_size(const std::string& how) {
    is_too_large_ = true;
    throw UsageError("the file has more than " + std::to_string(kLargestScenario) + " bytes" + how +
                     ", which is the limit");
  }

  void take_line(std::size_t number, std::string_view line) {
    const std::string text = variables_.expand(line);
    expanded_ += text.size();
    if (expanded_ > kLargestScenario) refuse_size(" with the values of its variables");
    if (variables_.let(text)) return;
    std::vector<std::string> words = split_words(text);
    if (words.empty()) return;
    if (words.front() == "finally") {
      begin_final(words);
      return;
    }
    ScenarioCommand parsed = parse_scenario_command(commands_, std::move(words));
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

  const CommandTable commands_;
  Scenario scenario_;
  Variables variables_;
  std::size_t bytes_ = 0;     ///< of the file so far
  std::size_t expanded_ = 0;  ///< of its lines without comments, with variables replaced
  bool is_final_ = false;
  bool is_too_large_ = false;
  Mistakes mistakes_;
};

/// Reads the lines of a file. Stops reading at a line that is longer than the limit.
class LineSource {
 public:
  explicit LineSource(std::istream& input) : input_(input), buffer_(kLongestLine + 2) {}

  /// @return the next line, valid until the next call; nothing at the end. Of a line that is too
  ///         long, only its beginning, which still exceeds kLongestLine.
  std::optional<std::string_view> next() {
    input_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    auto length = static_cast<std::size_t>(input_.gcount());
    const bool has_end = input_.good();
    if (length == 0) return std::nullopt;
    return std::string_view(buffer_.data(), has_end ? length - 1 : length);
  }

 private:
  std::istream& input_;
  std::vector<char> buffer_;
};

Scenario load(CommandTable commands, const std::string& name, const Variables::Values& settings) {
  if (name == "-") return parse_scenario(commands, std::cin, name_of_scenario(name), settings);
  std::ifstream file(name);
  // A directory can be opened, but not read.
  if (!file || std::filesystem::is_directory(name)) {
    throw UsageError("cannot read " + in_quotes(name));
  }
  return parse_scenario(commands, file, name, settings);
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
  refuse_longer(line);
  WordSplitter splitter;
  for (const char c : line.substr(0, comment_start(line))) splitter.take(c);
  return std::move(splitter).finish();
}

Scenario parse_scenario(CommandTable commands, std::istream& input, const std::string& file,
                        const Variables::Values& settings) {
  ScenarioReader reader(commands, file, settings);
  LineSource lines(input);
  std::size_t number = 0;
  for (auto line = lines.next(); line && reader.take(++number, *line);) line = lines.next();
  return std::move(reader).finish();
}

std::string name_of_scenario(const std::string& file) {
  return file == "-" ? "<stdin>" : file;
}

std::vector<Scenario> load_scenarios(CommandTable commands, const std::vector<std::string>& names,
                                     const Variables::Values& settings, Mistake mistake) {
  std::vector<Scenario> scenarios;
  scenarios.reserve(names.size());
  Mistakes mistakes;
  for (const std::string& name : names) {
    try {
      scenarios.push_back(load(commands, name, settings));
    } catch (const UsageError& error) {
      mistakes.note(error.what());
      scenarios.push_back({.file = name_of_scenario(name), .mistake = error.what()});
    }
  }
  if (mistake == Mistake::refuses_all) mistakes.throw_if_any();
  // A file with a mistake was not read to its end: the rest of it may use any variable.
  const bool are_whole = std::ranges::all_of(scenarios, [](const Scenario& one) {
    return one.mistake.empty();
  });
  if (!are_whole) return scenarios;
  for (const auto& [variable, value] : settings) {
    const bool is_used = std::ranges::any_of(scenarios, [&name = variable](const Scenario& one) {
      return one.variables.contains(name);
    });
    if (!is_used) throw UsageError(unused_variable(variable, scenarios));
  }
  return scenarios;
}

}  // namespace vdrive::tool
