// SPDX-License-Identifier: Apache-2.0
#include "configuration/configuration_help.hpp"

#include "configuration/configuration_file.hpp"
#include "configuration/configuration_keys.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>

namespace vdrive::service {
namespace {

/// @return the value at `path` in the output of --print-config; empty if it has no such key.
std::string default_of(const YAML::Node& printed, std::string_view path) {
  YAML::Node node = YAML::Clone(printed);
  while (!path.empty()) {
    const std::string_view key = path.substr(0, path.find('.'));
    path.remove_prefix(std::min(path.size(), key.size() + 1));
    const bool is_list = key.ends_with("[]");
    node.reset(node[std::string(key.substr(0, key.size() - (is_list ? 2 : 0)))]);
    if (is_list && node) node.reset(node[0]);
    if (!node) return {};
  }
  return node.IsScalar() ? node.Scalar() : std::string();
}

void add(std::string& help, std::string_view key, const std::string& text) {
  help.append(key).append("\n    ").append(text).append("\n");
}

}  // namespace

std::vector<ConfigurationKey> configuration_keys() {
  std::vector<ConfigurationKey> keys;
  settings::describe_section("", configuration_rows(), keys);
  return keys;
}

std::string configuration_help() {
  const YAML::Node printed = YAML::Load(to_yaml(demo_configuration()));
  std::string help;
  for (const ConfigurationKey& key : configuration_keys()) {
    const bool states_its_default = key.what.find("Default:") != std::string::npos;
    const std::string value = states_its_default ? "" : default_of(printed, key.path);
    add(help, key.path, key.what + (value.empty() ? "" : " Default: " + value + "."));
  }
  return help;
}

}  // namespace vdrive::service
