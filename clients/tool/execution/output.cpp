// SPDX-License-Identifier: Apache-2.0
#include "execution/output.hpp"

namespace vdrive::tool {

void report_usage(const Output& output, const std::string& message) {
  if (output.is_json) output.terminal.print(to_line({{"outcome", "usage"}, {"message", message}}));
  output.terminal.complain("vdrive: " + message);
}

client::Outcome report_clock(const Output& output, Json json, const std::string& text,
                             const client::Result<std::uint64_t>& tick) {
  if (output.is_quiet) return tick.outcome();
  if (output.is_json) {
    add_outcome(json, tick.outcome());
    if (tick) json["tick"] = *tick;
    output.terminal.print(to_line(json));
  } else if (tick) {
    output.terminal.print(text + " tick " + std::to_string(*tick));
  }
  return tick.outcome();
}

}  // namespace vdrive::tool
