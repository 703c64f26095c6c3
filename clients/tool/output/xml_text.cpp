// SPDX-License-Identifier: Apache-2.0
#include "output/xml_text.hpp"

namespace vdrive::tool {

std::string xml_text(std::string_view text, std::size_t longest) {
  std::string safe;
  for (const char c : escaped(text, longest)) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

}  // namespace vdrive::tool
