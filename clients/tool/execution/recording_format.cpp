// SPDX-License-Identifier: Apache-2.0
#include "execution/recording_format.hpp"

#include "base/usage_error.hpp"
#include "vdrive/text.hpp"

namespace vdrive::tool {

recording::Format format_of_file(const std::string& file) {
  const auto format = recording::format_of(file);
  if (format) return *format;
  throw UsageError(in_quotes(file) + " does not end in .csv, .jsonl or .mcap");
}

Duration parse_period(const std::string& text, const std::string& file) {
  if (format_of_file(file) == recording::Format::mcap) {
    throw UsageError(
        "--period applies only to .csv and .jsonl; an MCAP recording contains its period");
  }
  const Duration period = parse_duration(text);
  if (period.count() <= 0) throw UsageError("--period must be above 0");
  return period;
}

}  // namespace vdrive::tool
