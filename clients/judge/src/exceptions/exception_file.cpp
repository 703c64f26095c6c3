// SPDX-License-Identifier: Apache-2.0
#include "exceptions/exception_file.hpp"

#include "settings/yaml_reader.hpp"
#include "vdrive/wording.hpp"

#include <array>
#include <string_view>

namespace vdrive::judge {
namespace {

using settings::YamlValue;

constexpr std::array<std::string_view, 3> kKeys{"rule", "axis", "reason"};

Rule rule_of(const YamlValue& value) {
  const std::string name = value.text();
  if (const auto rule = find_rule(name)) return *rule;
  std::vector<std::string> names;
  for (const RuleRow& row : rules()) names.emplace_back(row.name);
  value.refuse("is no rule" + suggestion(name, names) + "; vdrive judge --rules lists them");
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
  if (!has_rule) entry.refuse("has no rule");
  if (exception.reason.find_first_not_of(' ') == std::string::npos) {
    entry.refuse("has no reason: say why the master does this on purpose");
  }
  return exception;
}

}  // namespace

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
