// SPDX-License-Identifier: Apache-2.0
#include "values/condition.hpp"

#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>

namespace vdrive::tool {
namespace {

/// @return "set_point_acknowledge" for "set-point acknowledge".
std::string condition_name(std::string_view text) {
  std::string name(text);
  for (char& c : name) {
    if (c == ' ' || c == '-') c = '_';
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return name;
}

std::vector<std::string> all_names() {
  constexpr auto kLastState = static_cast<int>(PowerState::fault);
  constexpr std::uint16_t kEnabled = 0x0027;  // Operation enabled; bits 12 and 13 belong to the
                                              // mode
  constexpr unsigned kBits = 16;
  std::vector<std::string> names;
  for (int state = 0; state <= kLastState; ++state) {
    names.push_back(condition_name(to_string(static_cast<PowerState>(state))));
  }
  for (const OperatingModeRow& row : kOperatingModes) {
    if (row.mode == OperatingMode::none) continue;
    for (unsigned bit = 0; bit < kBits; ++bit) {
      const auto word = static_cast<std::uint16_t>(kEnabled | 1U << bit);
      for (const std::string_view flag : client::statusword_flags(word, row.mode)) {
        std::string name = condition_name(flag);
        const bool is_known = std::ranges::find(names, name) != names.end();
        if (!is_known && !name.starts_with("bit_")) names.push_back(std::move(name));
      }
    }
  }
  return names;
}

/// @return whether `name` contains these words, as operation_enabled contains "enabled".
bool has_words(std::string_view name, std::string_view words) {
  const auto between_words = [](std::string_view text) {
    return "_" + std::string(text) + "_";
  };
  return between_words(name).find(between_words(words)) != std::string::npos;
}

}  // namespace

const std::vector<std::string>& condition_names() {
  static const std::vector<std::string> names = all_names();
  return names;
}

std::string condition_suggestion(std::string_view name) {
  std::string nearest = suggestion(name, condition_names());
  if (!nearest.empty()) return nearest;
  std::string meant;
  for (const std::string& known : condition_names()) {
    if (!has_words(known, name)) continue;
    meant += (meant.empty() ? "" : " or ") + in_quotes(known);
  }
  return meant.empty() ? meant : " (did you mean " + meant + "?)";
}

bool shows(const client::AxisSnapshot& axis, std::string_view name) {
  if (condition_name(to_string(axis.state())) == name) return true;
  return std::ranges::any_of(client::statusword_flags(axis.status.ds402_statusword, axis.mode()),
                             [name](std::string_view flag) {
                               return condition_name(flag) == name;
                             });
}

}  // namespace vdrive::tool
