// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/report_file.hpp"

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// One line of a scenario as a test case.
struct JunitCase {
  /// The types of cases that were not judged.
  static constexpr const char* kNotRun = "not_run";
  static constexpr const char* kInterrupted = "interrupted";

  std::string name;
  std::chrono::nanoseconds duration{};                ///< wall time
  std::optional<std::string> failure = std::nullopt;  ///< the deviation; none = passed
  std::optional<std::string> error = std::nullopt;    ///< why it could not be judged
  bool is_skipped = false;
  std::size_t line = 0;  ///< in the file of its suite; 0 = none

  /// The kind of the failure or error, such as "expectation".
  std::string type{};
  /// All details of the failure or error, with file and line; empty = only the message.
  std::string text{};

  std::string output{};  ///< printed output
};

/// A scenario as a test suite.
struct JunitSuite {
  std::string name;  ///< the file
  std::vector<JunitCase> cases;
};

/// The part of the files that one of several runs executes.
struct Shard {
  static constexpr std::size_t kMost = 100'000;  ///< the limit of an Indexed Job of Kubernetes

  std::size_t number = 1;  ///< from 1
  std::size_t count = 1;
  std::size_t files = 0;  ///< of all shards together; 0 = unknown
};

/// The contents of a report.
struct JunitContent {
  std::vector<JunitSuite> suites;
  std::optional<Shard> shard;
};

/// @param shard to which the suites belong; none = they cover all files
[[nodiscard]] std::string junit_xml(const std::vector<JunitSuite>& suites,
                                    const std::optional<Shard>& shard = std::nullopt);

/// @param xml written by junit_xml()
/// @throws UsageError for anything else, with the line.
[[nodiscard]] JunitContent read_junit(const std::string& xml);

/// The file of `--junit`.
class JunitReport {
 public:
  /// @param file empty = no report
  /// @throws UsageError if the file cannot be written.
  explicit JunitReport(const std::string& file) : file_("--junit", file) {}

  /// @return why the report could not be written, or nothing.
  [[nodiscard]] std::optional<std::string> write(const std::vector<JunitSuite>& suites,
                                                 const std::optional<Shard>& shard = std::nullopt);

 private:
  ReportFile file_;
};

}  // namespace vdrive::tool
