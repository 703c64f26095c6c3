// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "language/command.hpp"
#include "vdrive/client/outcome.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Help for the user after a command of a scenario has failed, in addition to its message.
struct FailureReport {
  std::optional<std::uint64_t> tick{};  ///< tick of the failure, if known

  /// The status of the axes, one line each, with the statusword (6041h) decoded.
  std::vector<std::string> axes{};

  std::string advice{};  ///< next step; empty only after an interrupt
};

/// Reads the axes that the command names, or else those of earlier commands. In lock-step no time
/// passes.
[[nodiscard]] FailureReport report_failure(const Command& command, const client::Outcome& outcome,
                                           CommandContext& context);

/// @return the kind of failure, for readers of reports: "expectation" if a value or a refusal
///         differs from the expected one, otherwise the name of the outcome, such as "refused".
[[nodiscard]] std::string failure_type(const client::Outcome& outcome,
                                       const std::optional<Json>& found);

}  // namespace vdrive::tool
