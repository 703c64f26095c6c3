// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/exceptions.hpp"

#include <string>
#include <vector>

namespace vdrive::judge {

/// Reads a YAML file that lists rules which a master breaks on purpose:
///
///     - rule: handshake-8
///       axis: node 5          # every axis without it
///       reason: the drive looks at its controlword every 125 us
///
/// @throws settings::ConfigurationError naming file, line and key, for anything else: an unknown
///         rule, an exception without a reason.
[[nodiscard]] std::vector<Exception> read_exceptions(const std::string& text,
                                                     const std::string& file_name);

/// Reads the exceptions in the comments of a scenario:
///
///     # judge: off handshake-8 because the drive looks at its controlword every 125 us
///     # judge: off motion-1 on 1.2 because this file is about the limits
///
/// @throws settings::ConfigurationError naming file and line, for a comment that begins with
///         "judge:" and does not have this form, and for an unknown rule.
[[nodiscard]] std::vector<Exception> read_exception_comments(const std::string& text,
                                                             const std::string& file_name);

}  // namespace vdrive::judge
