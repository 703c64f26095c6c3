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
  /// The types of what was not judged.
  static constexpr const char* kNotRun = "not_run";
  static constexpr const char* kInterrupted = "interrupted";

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

/// Which part of all files a run has, where several share them.
struct Shard {
  static constexpr std::size_t kMost = 100'000;  ///< as many as an Indexed Job of Kubernetes has

  std::size_t number = 1;  ///< from 1
  std::size_t count = 1;
  std::size_t files = 0;  ///< of all shards together; 0 = not known
};

/// What a report holds.
struct JunitContent {
  std::vector<JunitSuite> suites;
  std::optional<Shard> shard;
};

/// @param shard that the suites are of; none = they are of all files
[[nodiscard]] std::string junit_xml(const std::vector<JunitSuite>& suites,
                                    const std::optional<Shard>& shard = std::nullopt);

/// @param xml what junit_xml() has made
/// @throws UsageError for anything else, with its line.
[[nodiscard]] JunitContent read_junit(const std::string& xml);

/// The file of `--junit`.
class JunitReport {
 public:
  /// @param file empty = no report
  /// @throws UsageError when the file cannot be written.
  explicit JunitReport(const std::string& file) : file_("--junit", file) {}

  /// @return why the report could not be written, or nothing.
  [[nodiscard]] std::optional<std::string> write(const std::vector<JunitSuite>& suites,
                                                 const std::optional<Shard>& shard = std::nullopt);

 private:
  ReportFile file_;
};

}  // namespace vdrive::tool
