// SPDX-License-Identifier: Apache-2.0
#include "settings/configuration_error.hpp"

#include <utility>

namespace vdrive::settings {
namespace {

std::string lines_of(const std::vector<std::string>& mistakes) {
  std::string lines;
  for (const std::string& mistake : mistakes) lines += (lines.empty() ? "" : "\n") + mistake;
  return lines;
}

}  // namespace

ConfigurationError::ConfigurationError(const std::string& mistake)
    : ConfigurationError(std::vector{mistake}) {}

ConfigurationError::ConfigurationError(std::vector<std::string> mistakes)
    : std::runtime_error(lines_of(mistakes)),
      mistakes_(std::make_shared<const std::vector<std::string>>(std::move(mistakes))) {}

void Mistakes::throw_if_any() const {
  if (texts_.empty()) return;
  std::vector<std::string> texts = texts_;
  if (is_cut_ || texts.size() > kMost) {
    texts.resize(kMost);
    texts.push_back("stopped after " + std::to_string(kMost) + " mistakes");
  }
  throw ConfigurationError(std::move(texts));
}

}  // namespace vdrive::settings
