// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/report.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/outcome.hpp"

#include <cstdint>
#include <string>

namespace vdrive::tool {

/// Where the commands of a session write what they answer.
struct Output {
  Terminal& terminal;
  bool is_json;         ///< one JSON object a line instead of text
  const bool is_quiet;  ///< only commands that read print; the others print nothing
};

/// A mistake in the command line, which has no command yet.
void report_usage(const Output& output, const std::string& message);

/// What a command about a bench's clock came to, and at which tick.
client::Outcome report_clock(const Output& output, Json json, const std::string& text,
                             const client::Result<std::uint64_t>& tick);

}  // namespace vdrive::tool
