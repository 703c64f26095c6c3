// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "format.hpp"

#include <string>

namespace vdrive::tool {

/// @return the format of a recording by the ending of its file.
/// @throws UsageError for another ending.
[[nodiscard]] recording::Format format_of_file(const std::string& file);

}  // namespace vdrive::tool
