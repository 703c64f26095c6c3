// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
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
  std::size_t line = 0;  ///< of the file of its suite; 0 = of none

  /// Of a failure or an error: what kind it is, such as "expectation", and all that is known of it,
  /// with its place; empty = the message alone.
  std::string type{};
  std::string text{};

  std::string output{};  ///< what it printed
};

/// A scenario.
struct JunitSuite {
  std::string name;  ///< the file
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
