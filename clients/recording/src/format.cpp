// SPDX-License-Identifier: Apache-2.0
#include "format.hpp"

namespace vdrive::recording {

std::optional<Format> format_of(std::string_view file) noexcept {
  if (file.ends_with(".csv")) return Format::csv;
  if (file.ends_with(".jsonl") || file.ends_with(".json")) return Format::json_lines;
  if (file.ends_with(".mcap")) return Format::mcap;
  return std::nullopt;
}

}  // namespace vdrive::recording
