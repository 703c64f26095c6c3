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

/// What helps a person to go on after a command of a scenario has failed, beside its message.
struct FailureReport {
  std::optional<std::uint64_t> tick{};  ///< in which it failed, as far as it is known

  /// What the axes show, one line each, with the statusword (6041h) decoded.
  std::vector<std::string> axes{};

  std::string advice{};  ///< the next step; empty after an interrupt only
};

/// Looks at the axes that the command names, or else at those that commands before it have named.
/// In lock-step no time passes.
[[nodiscard]] FailureReport report_failure(const Command& command, const client::Outcome& outcome,
                                           CommandContext& context);

/// @return what kind of failure it is, for a reader of reports: "expectation" where a value or a
///         refusal differs from what was expected, else the name of the outcome, such as "refused".
[[nodiscard]] std::string failure_type(const client::Outcome& outcome,
                                       const std::optional<Json>& found);

}  // namespace vdrive::tool
