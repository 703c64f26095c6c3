// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::tool {

/// The file of a report. It is opened before anything moves or is read, so that a wrong name is
/// found early.
class ReportFile {
 public:
  /// @param option that names the file, such as "--junit"
  /// @param file empty = no report
  /// @throws UsageError if the file cannot be written.
  ReportFile(std::string_view option, const std::string& file);

  [[nodiscard]] bool is_wanted() const noexcept { return !name_.empty(); }

  /// @return why the report could not be written, or nothing.
  [[nodiscard]] std::optional<std::string> write(std::string_view text);

 private:
  std::string name_;
  std::ofstream file_;
};

}  // namespace vdrive::tool
