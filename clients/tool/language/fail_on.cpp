// SPDX-License-Identifier: Apache-2.0
#include "language/fail_on.hpp"

#include <string>

namespace vdrive::tool {
namespace {

std::optional<judge::Severity> parse_fail_on(const std::string& text) {
  return text == "never" ? std::nullopt : judge::parse_severity(text);
}

}  // namespace

void declare_fail_on(Arguments& arguments, std::optional<judge::Severity>& fail_on) {
  arguments
      .option("--fail-on", "SEVERITY", fail_on,
              "Exit with 1 for findings of this severity and above: error (default), warning, "
              "advice, or never",
              parse_fail_on)
      .one_of({"error", "warning", "advice", "never"});
}

}  // namespace vdrive::tool
