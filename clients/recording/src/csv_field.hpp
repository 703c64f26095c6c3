// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vdrive::recording {

/// @return `text` as one field of CSV (RFC 4180).
[[nodiscard]] std::string csv_field(const std::string& text);

/// @param line without its line break
/// @return its fields. A quoted field that does not end takes the rest of the line.
[[nodiscard]] std::vector<std::string> csv_fields(std::string_view line);

}  // namespace vdrive::recording
