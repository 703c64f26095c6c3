// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "format.hpp"
#include "values/value.hpp"

#include <string>

namespace vdrive::tool {

/// @return the format of a recording, from the extension of its file.
/// @throws UsageError for any other extension.
[[nodiscard]] recording::Format format_of_file(const std::string& file);

/// @param text period of a tick, for a recording without one
/// @param file the recording
/// @throws UsageError for a period that is not above 0, and for a recording that has its own.
[[nodiscard]] Duration parse_period(const std::string& text, const std::string& file);

}  // namespace vdrive::tool
