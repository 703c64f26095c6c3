// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// One line of a scenario as a test case.
struct JunitCase {
  std::string name;
  std::chrono::nanoseconds duration{};  ///< wall time
  std::optional<std::string> failure;   ///< none = passed
  bool is_skipped = false;
};

/// @return a JUnit report with one test suite.
[[nodiscard]] std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases);

}  // namespace vdrive::tool
