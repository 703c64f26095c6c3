// SPDX-License-Identifier: Apache-2.0
#include "exceptions/exception_file.hpp"

#include "settings/configuration_error.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <array>
#include <sstream>
#include <string_view>

namespace vdrive::judge {
namespace {

using settings::YamlValue;

constexpr std::array<std::string_view, 3> kKeys{"rule", "axis", "reason"};

constexpr const char* kNoReason = "has no reason: say why the master does this on purpose";

bool has_no_text(const std::string& text) {
  return text.find_first_not_of(' ') == std::string::npos;
}

std::string no_rule_text(const std::string& name) {
  std::vector<std::string> names;
  for (const RuleRow& row : rules()) names.emplace_back(row.name);
  return "is not a rule" + suggestion(name, names) + "; vdrive judge --rules lists them";
}

Rule rule_of(const YamlValue& value) {
  const std::string name = value.text();
  if (const auto rule = find_rule(name)) return *rule;
  value.refuse(no_rule_text(name));
}

Exception exception_of(const YamlValue& entry, const std::string& file_name) {
  Exception exception{.place = file_name + ":" + std::to_string(entry.line())};
  bool has_rule = false;
  entry.for_each_entry(kKeys, [&](const std::string& key, const YamlValue& value) {
    if (key == "rule") {
      exception.rule = rule_of(value);
      has_rule = true;
    } else if (key == "axis") {
      exception.axis = value.text();
    } else {
      exception.reason = value.text();
    }
  });
  if (!has_rule) entry.refuse("the key rule is missing");
  if (has_no_text(exception.reason)) entry.refuse(kNoReason);
  return exception;
}

constexpr std::string_view kMark = "judge:";
constexpr std::string_view kBecause = " because ";

/// @param comment the text after "judge:"
Exception exception_of_comment(const std::string& comment, const std::string& place) {
  const auto refuse = [&place](const std::string& what) {
    throw settings::ConfigurationError(place + ": " + what);
  };
  const std::size_t because = comment.find(kBecause);
  std::istringstream words(comment.substr(0, because));
  std::string off;
  std::string rule;
  std::string on;
  std::string axis;
  std::string rest;
  words >> off >> rule >> on >> axis >> rest;
  const bool is_form = off == "off" && !rule.empty() && rest.empty() &&
                       because != std::string::npos &&
                       (on.empty() || (on == "on" && !axis.empty()));
  if (!is_form) refuse("write '# judge: off RULE [on AXIS] because REASON'");
  Exception exception{.axis = axis.empty() ? "" : "axis " + axis,
                      .reason = comment.substr(because + kBecause.size()),
                      .place = place};
  const auto found = find_rule(rule);
  if (!found) refuse(in_quotes(rule) + " " + no_rule_text(rule));
  exception.rule = *found;
  if (has_no_text(exception.reason)) refuse(kNoReason);
  return exception;
}

}  // namespace

std::vector<Exception> read_exception_comments(const std::string& text,
                                               const std::string& file_name) {
  std::vector<Exception> exceptions;
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string::npos || line[begin] != '#') continue;
    const std::size_t word = line.find_first_not_of(" \t", begin + 1);
    if (word == std::string::npos || !std::string_view(line).substr(word).starts_with(kMark))
      continue;
    exceptions.push_back(exception_of_comment(line.substr(word + kMark.size()),
                                              file_name + ":" + std::to_string(number)));
  }
  return exceptions;
}

std::vector<Exception> read_exceptions(const std::string& text, const std::string& file_name) {
  std::vector<Exception> exceptions;
  const YAML::Node document = settings::read_yaml(text, file_name);
  if (document.IsNull()) return exceptions;
  YamlValue(document, file_name, "").for_each_element([&](const YamlValue& entry) {
    exceptions.push_back(exception_of(entry, file_name));
  });
  return exceptions;
}

}  // namespace vdrive::judge
