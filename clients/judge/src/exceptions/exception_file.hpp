// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/exceptions.hpp"

#include <string>
#include <vector>

namespace vdrive::judge {

/// Reads a YAML file with what a master does on purpose, a list:
///
///     - rule: handshake-8
///       axis: node 5          # every axis without it
///       reason: the drive looks at its controlword each 125 us
///
/// @throws settings::ConfigurationError naming file, line and key, for anything else: a rule that
///         is not there, an exception without a reason.
[[nodiscard]] std::vector<Exception> read_exceptions(const std::string& text,
                                                     const std::string& file_name);

}  // namespace vdrive::judge
