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

}  // namespace vdrive::tool
