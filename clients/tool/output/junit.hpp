// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// One line of a scenario as a test case.
struct JunitCase {
  std::string name;
  std::chrono::nanoseconds duration{};                ///< wall time
  std::optional<std::string> failure = std::nullopt;  ///< what was not as expected; none = passed
  std::optional<std::string> error = std::nullopt;    ///< why it could not be judged at all
  bool is_skipped = false;
};

/// A scenario.
struct JunitSuite {
  std::string name;
  std::vector<JunitCase> cases;
};

[[nodiscard]] std::string junit_xml(const std::vector<JunitSuite>& suites);

/// The file of a report. It is opened before anything moves, so that a wrong name is found then.
class JunitReport {
 public:
  /// @param file empty = no report
  /// @throws UsageError when the file cannot be written.
  explicit JunitReport(const std::string& file);

  /// @return why the report could not be written, or nothing.
  [[nodiscard]] std::optional<std::string> write(const std::vector<JunitSuite>& suites);

 private:
  std::string name_;
  std::ofstream file_;
};

}  // namespace vdrive::tool
