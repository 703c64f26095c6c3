// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/rule.hpp"
#include "language/arguments.hpp"

#include <optional>

namespace vdrive::tool {

/// --fail-on SEVERITY: which findings are failures.
/// @param fail_on nothing = none
/// @param is_given becomes true where the command line has it; null = nobody asks
void declare_fail_on(Arguments& arguments, std::optional<judge::Severity>& fail_on,
                     bool* is_given = nullptr);

}  // namespace vdrive::tool
