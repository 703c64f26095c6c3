// SPDX-License-Identifier: Apache-2.0
#include "configuration/configuration_file.hpp"

#include "configuration/configuration_keys.hpp"
#include "settings/configuration_error.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/text.hpp"

#include <yaml-cpp/yaml.h>

#include <span>
#include <stdexcept>

namespace vdrive::service {
namespace {

/// Tries each axis in a separate bank, because the bank checks rules that involve several values.
void try_axes(const ParsedAxes& parsed, std::chrono::microseconds period) {
  settings::Mistakes mistakes;
  for (const auto& axis : parsed.axes) {
    mistakes.collect([&] {
      try {
        const AxisBank bank(std::span(&axis.configuration, 1), period);
      } catch (const std::invalid_argument& refusal) {
        parsed.places.at(axis.number)
            .refuse("axis " + std::to_string(axis.number) + ": " + refusal.what());
      }
    });
  }
  mistakes.throw_if_any();
}

Configuration read_configuration(const YamlValue& root) {
  ParsedConfiguration parsed{.configuration = demo_configuration(), .axes = {}};
  settings::Mistakes mistakes;
  mistakes.collect([&] {
    settings::read_section(root, configuration_rows(), parsed);
  });
  // Axes were read if their own section has no mistake, even if another section has one.
  mistakes.collect([&] {
    try_axes(parsed.axes, parsed.configuration.period);
  });
  mistakes.throw_if_any();
  if (!parsed.axes.axes.empty()) parsed.configuration.axes = std::move(parsed.axes.axes);
  return std::move(parsed.configuration);
}

}  // namespace

Configuration parse_configuration(const std::string& text, const std::string& file_name) {
  const YAML::Node document = settings::read_yaml(text, file_name);
  if (document.IsNull()) return demo_configuration();
  return read_configuration(YamlValue(document, file_name, ""));
}

Configuration load_configuration(const std::filesystem::path& file) {
  const std::string text = settings::read_yaml_file(file);
  if (text.empty()) {
    throw ConfigurationError(escaped(file.string(), kShownOfMessage) +
                             ": is empty; without --config the service has the demo bench");
  }
  return parse_configuration(text, file.string());
}

std::string to_yaml(const Configuration& configuration) {
  ParsedConfiguration printed{configuration, {}};
  printed.configuration.watchdog = effective_watchdog(configuration);
  printed.configuration.wire_form = effective_wire_form(configuration);
  YAML::Emitter out;
  settings::write_section(out, configuration_rows(), printed);
  return std::string(out.c_str()) + "\n";
}

}  // namespace vdrive::service
