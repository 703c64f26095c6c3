// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "format.hpp"
#include "values/value.hpp"

#include <string>

namespace vdrive::tool {

/// @return the format of a recording by the ending of its file.
/// @throws UsageError for another ending.
[[nodiscard]] recording::Format format_of_file(const std::string& file);

/// @param text the time of a tick of a recording
/// @param file the recording
/// @throws UsageError for no time above 0, and for a recording that has this time.
[[nodiscard]] Duration parse_period(const std::string& text, const std::string& file);

}  // namespace vdrive::tool
