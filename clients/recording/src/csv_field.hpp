// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vdrive::recording {

/// @return `text` as one CSV field (RFC 4180).
[[nodiscard]] std::string csv_field(const std::string& text);

/// @param line without its line break
/// @return its fields. An unterminated quoted field extends to the end of the line.
[[nodiscard]] std::vector<std::string> csv_fields(std::string_view line);

}  // namespace vdrive::recording
