// SPDX-License-Identifier: Apache-2.0
#include "configuration/presets.hpp"

#include "configuration/configuration_file.hpp"
#include "configuration/preset_texts.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>

namespace vdrive::service {

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  names.reserve(kPresetTexts.size());
  for (const PresetText& preset : kPresetTexts) names.emplace_back(preset.name);
  return names;
}

std::vector<NamedAxis> preset_axes(const std::string& name, std::size_t count) {
  const auto* const preset = std::ranges::find(kPresetTexts, name, &PresetText::name);
  if (preset == kPresetTexts.end()) {
    throw ConfigurationError("preset: " + refusal_of_choice(name, preset_names()));
  }
  const Configuration machine = parse_configuration(std::string(preset->text), name + ".yaml");
  std::vector<NamedAxis> axes = default_axes(count);
  for (NamedAxis& axis : axes) {
    axis.unit = machine.axes.front().unit;
    axis.configuration = machine.axes.front().configuration;
  }
  return axes;
}

}  // namespace vdrive::service
