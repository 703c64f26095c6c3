// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/text.hpp"

#include <cstddef>
#include <string>
#include <string_view>

namespace vdrive::tool {

/// @param longest as in escaped()
/// @return `text` as the content of an element or an attribute of XML or HTML, on one line and
///         without control characters.
[[nodiscard]] std::string xml_text(std::string_view text, std::size_t longest = kShownOfMessage);

}  // namespace vdrive::tool
