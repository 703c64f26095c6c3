// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/outcome.hpp"

namespace vdrive::tool {

/// The exit codes of the tool.
enum class ExitCode : int {
  ok = 0,
  failed = 1,
  usage = 2,
  not_found = 3,
  timed_out = 4,
  refused = 5,
  not_run = 6,     ///< test: the machine lacks something the test needs; it may pass when repeated
  unreadable = 7,  ///< `judge`: the log or journal cannot be judged
  interrupted = 130,
};

/// @return the exit code for an outcome; a lost service counts as failed.
[[nodiscard]] ExitCode exit_code_of(client::OutcomeKind kind) noexcept;

}  // namespace vdrive::tool
