// SPDX-License-Identifier: Apache-2.0
#include "language/fail_on.hpp"

#include <string>

namespace vdrive::tool {
void declare_fail_on(Arguments& arguments, std::optional<judge::Severity>& fail_on,
                     bool* is_given) {
  arguments
      .option("--fail-on", "SEVERITY", fail_on,
              "Exit with 1 for findings of this severity and above: error (default), warning, "
              "advice, or never",
              [is_given](const std::string& text) {
                if (is_given != nullptr) *is_given = true;
                return text == "never" ? std::nullopt : judge::parse_severity(text);
              })
      .one_of({"error", "warning", "advice", "never"});
}

}  // namespace vdrive::tool
