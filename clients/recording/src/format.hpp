// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// Formats of recordings: CSV and JSON lines with the status, MCAP with the status, events and
/// parameters as ROS 2 messages.
namespace vdrive::recording {

enum class Format : std::uint8_t { csv, json_lines, mcap };

/// @return the format for the extension of a file name: .csv, .jsonl or .json, .mcap; nothing for
///         any other.
[[nodiscard]] constexpr std::optional<Format> format_of(std::string_view file) noexcept {
  if (file.ends_with(".csv")) return Format::csv;
  if (file.ends_with(".jsonl") || file.ends_with(".json")) return Format::json_lines;
  if (file.ends_with(".mcap")) return Format::mcap;
  return std::nullopt;
}

}  // namespace vdrive::recording
