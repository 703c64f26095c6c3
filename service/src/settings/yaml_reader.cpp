// SPDX-License-Identifier: Apache-2.0
#include "settings/yaml_reader.hpp"

#include "settings/configuration_error.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>

namespace vdrive::settings {
namespace {

std::string with_unit(const std::string& number, std::string_view unit) {
  return unit.empty() ? number : number + " " + std::string(unit);
}

[[noreturn]] void refuse_line(const std::string& file_name, std::size_t line,
                              const std::string& problem) {
  throw ConfigurationError(escaped(file_name, kShownOfMessage) + ":" + std::to_string(line) + ": " +
                           problem);
}

/// Needed because the parser also accepts UTF-16 and UTF-32, and replaces invalid characters.
void check_encoding(const std::string& text, const std::string& file_name) {
  if (is_wide_text(text)) {
    throw ConfigurationError(escaped(file_name, kShownOfMessage) +
                             ": is encoded in UTF-16 or UTF-32; it must be UTF-8");
  }
  std::istringstream lines(text);
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (!is_utf8(line) || line.find('\0') != std::string::npos) {
      refuse_line(file_name, number, in_quotes(line) + " is not valid UTF-8");
    }
  }
}

constexpr std::size_t kDeepest = 32;  // a configuration has five levels
/// The number of values that the largest file could contain without aliases.
constexpr std::size_t kMostValues = kLargestSettingsFile / 2;

/// Notes where each document begins, and refuses small files that would take long to read: with
/// deeply nested lists, or with aliases of aliases, which multiply their content.
class DocumentCheck : public YAML::EventHandler {
 public:
  explicit DocumentCheck(const std::string& file_name) : file_name_(file_name) {}

  std::vector<YAML::Mark> starts;

  void OnDocumentStart(const YAML::Mark& mark) override { starts.push_back(mark); }

  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { count(mark, anchor, 1); }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto named = sizes_.find(anchor);
    if (named == sizes_.end()) refuse(mark, "an alias refers to a node that contains it");
    count(mark, YAML::NullAnchor, named->second);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                const std::string& /*value*/) override {
    count(mark, anchor, 1);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(mark, anchor);
  }

  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(mark, anchor);
  }

  void OnMapEnd() override { close(); }

 private:
  /// A list or a map that has not ended.
  struct Open {
    YAML::anchor_t anchor;
    std::size_t values_before;
  };

  void open(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (open_.size() == kDeepest) {
      refuse(mark, "nested more than " + std::to_string(kDeepest) + " levels deep");
    }
    open_.push_back({anchor, values_});
    count(mark, YAML::NullAnchor, 1);
  }

  void close() {
    if (open_.back().anchor != YAML::NullAnchor) {
      sizes_[open_.back().anchor] = values_ - open_.back().values_before;
    }
    open_.pop_back();
  }

  void count(const YAML::Mark& mark, YAML::anchor_t anchor, std::size_t size) {
    values_ += size;
    if (values_ > kMostValues) {
      refuse(mark, "more than " + std::to_string(kMostValues) +
                       " values, with each alias replaced by what it names");
    }
    if (anchor != YAML::NullAnchor) sizes_[anchor] = size;
  }

  [[noreturn]] void refuse(const YAML::Mark& mark, const std::string& problem) const {
    refuse_line(file_name_, static_cast<std::size_t>(mark.line) + 1, problem);
  }

  const std::string& file_name_;
  std::vector<Open> open_;
  std::size_t values_ = 0;                       ///< so far, in all documents
  std::map<YAML::anchor_t, std::size_t> sizes_;  ///< of complete nodes with an anchor [values]
};

/// Not `YAML::LoadAll`, because it never returns if the text continues with something that no
/// document can begin with, such as a comma: it keeps finding empty documents at the same place.
void check_that_one_document_is_all(const std::string& text, const std::string& file_name) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentCheck documents(file_name);
  if (!parser.HandleNextDocument(documents) || !parser.HandleNextDocument(documents)) return;
  const auto line = [&documents](std::size_t document) {
    return static_cast<std::size_t>(documents.starts.at(document).line) + 1;
  };
  if (documents.starts.at(0).pos == documents.starts.at(1).pos) {
    refuse_line(file_name, line(0), "a YAML document cannot begin like this");
  }
  refuse_line(file_name, line(1),
              "a second YAML document begins here; a configuration is one document");
}

/// YAML allows only spaces for indentation, but the parser's error does not mention the tab.
/// @return the first line, up to `last`, that is indented with a tab; 0 = none
std::size_t first_line_with_tab(const std::string& text, std::size_t last) {
  std::istringstream lines(text);
  std::string line;
  for (std::size_t number = 1; number <= last && std::getline(lines, line); ++number) {
    const std::size_t indented = line.find_first_not_of(' ');
    if (indented != std::string::npos && line[indented] == '\t') return number;
  }
  return 0;
}

}  // namespace

std::string read_yaml_file(const std::filesystem::path& file) {
  const auto refuse = [&file](const std::string& problem) {
    throw ConfigurationError(escaped(file.string(), kShownOfMessage) + ": " + problem);
  };
  const std::string limit = std::to_string(kLargestSettingsFile);
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse("cannot be read: " + std::generic_category().message(errno));
  if (std::filesystem::is_directory(file)) refuse("is a directory, not a file");
  std::error_code has_no_size;
  const std::uintmax_t size = std::filesystem::file_size(file, has_no_size);
  if (!has_no_size && size > kLargestSettingsFile) {
    refuse("has " + std::to_string(size) + " bytes; the limit is " + limit);
  }
  std::string text(kLargestSettingsFile + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) refuse("cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kLargestSettingsFile) {  // a pipe, or a file that grows
    refuse("has more bytes than the limit, " + limit);
  }
  return text;
}

YAML::Node read_yaml(const std::string& text, const std::string& file_name) {
  check_encoding(text, file_name);
  try {
    check_that_one_document_is_all(text, file_name);
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    const auto line = static_cast<std::size_t>(error.mark.line) + 1;
    if (const std::size_t tab = first_line_with_tab(text, line); tab != 0) {
      refuse_line(file_name, tab, "this line is indented with a tab; YAML allows only spaces");
    }
    refuse_line(file_name, line, escaped(error.msg, kShownOfMessage));
  }
}

void YamlValue::for_each_entry(
    std::span<const std::string_view> known,
    const std::function<void(const std::string&, const YamlValue&)>& visit) const {
  if (!node_.IsMap()) refuse("must be a map of keys and values");
  std::set<std::string> seen;
  Mistakes mistakes;
  for (const auto& entry : node_) {
    mistakes.collect([&] {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      const std::string path = path_.empty() ? key : path_ + "." + key;
      const YamlValue name(entry.first, file_, path);
      if (!known.empty() && std::ranges::find(known, key) == known.end()) {
        const std::vector<std::string> names(known.begin(), known.end());
        name.refuse("unknown key" + suggestion(key, names) + "; known here: " + joined(names));
      }
      if (!seen.insert(key).second) name.refuse("the key appears twice");
      visit(key, YamlValue(entry.second, file_, path));
    });
  }
  mistakes.throw_if_any();
}

void YamlValue::for_each_element(const std::function<void(const YamlValue&)>& visit) const {
  if (!node_.IsSequence()) refuse("must be a list");
  Mistakes mistakes;
  for (std::size_t position = 0; position < node_.size(); ++position) {
    mistakes.collect([&] {
      visit(YamlValue(node_[position], file_, path_ + "[" + std::to_string(position) + "]"));
    });
  }
  mistakes.throw_if_any();
}

std::int64_t YamlValue::integer(const IntegerLimits& limits) const {
  const auto value = parse_integer(text());
  if (!value || *value < limits.lowest || *value > limits.highest) {
    refuse("must be a whole number from " + std::to_string(limits.lowest) + " to " +
           with_unit(std::to_string(limits.highest), limits.unit));
  }
  return *value;
}

double YamlValue::number(std::string_view unit) const {
  const auto value = parse_number(text());
  if (!value) {
    refuse("must be a finite number" + (unit.empty() ? "" : " [" + std::string(unit) + "]"));
  }
  return *value;
}

double YamlValue::number(const NumberLimits& limits) const {
  const double value = number(limits.unit);
  if (value < limits.lowest || value > limits.highest) {
    refuse("must be from " + to_text(limits.lowest) + " to " +
           with_unit(to_text(limits.highest), limits.unit));
  }
  return value;
}

bool YamlValue::boolean() const {
  constexpr std::array kWords{Choice{"false", 0}, Choice{"true", 1}};
  return choice(kWords) == 1;
}

std::string YamlValue::text() const {
  if (!node_.IsScalar()) refuse("must be a single value");
  return node_.Scalar();
}

int YamlValue::choice(const Choices& choices) const {
  const std::string value = text();
  const auto found = std::ranges::find(choices, value, &Choice::name);
  if (found == choices.end()) {
    std::vector<std::string> names;
    for (const Choice& each : choices) names.emplace_back(each.name);
    refuse("must be one of " + joined(names) + suggestion(value, names));
  }
  return found->value;
}

int YamlValue::line() const {
  const YAML::Mark mark = node_.Mark();
  return mark.is_null() ? 1 : mark.line + 1;
}

std::string YamlValue::message(const std::string& problem) const {
  std::string text = escaped(file_, kShownOfMessage) + ":" + std::to_string(line()) + ": ";
  if (!path_.empty()) {
    text += escaped(path_);
    // The path of a key ends with the key itself.
    const std::string& scalar = node_.Scalar();
    const bool is_key = path_ == scalar || path_.ends_with("." + scalar);
    if (node_.IsScalar() && !scalar.empty() && !is_key) text += " = " + escaped(scalar);
    text += ": ";
  }
  return text + problem;
}

void YamlValue::refuse(const std::string& problem) const {
  throw ConfigurationError(message(problem));
}

}  // namespace vdrive::settings
