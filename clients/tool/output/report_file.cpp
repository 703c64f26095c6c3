// SPDX-License-Identifier: Apache-2.0
#include "output/report_file.hpp"

#include "base/usage_error.hpp"
#include "vdrive/text.hpp"

#include <cerrno>
#include <system_error>

namespace vdrive::tool {

ReportFile::ReportFile(std::string_view option, const std::string& file) : name_(file) {
  if (file.empty()) return;
  errno = 0;
  file_.open(file, std::ios::binary | std::ios::trunc);
  if (file_) return;
  throw UsageError(std::string(option) + ": cannot write " + in_quotes(file) + ": " +
                   std::generic_category().message(errno));
}

std::optional<std::string> ReportFile::write(std::string_view text) {
  if (file_ << text << std::flush) return std::nullopt;
  return "cannot write the report " + in_quotes(name_);
}

}  // namespace vdrive::tool
