// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/rule.hpp"
#include "language/arguments.hpp"

#include <optional>

namespace vdrive::tool {

/// --fail-on SEVERITY: the findings that count as failures.
/// @param fail_on nothing = none
/// @param is_given set to true if the command line has the option; may be null
void declare_fail_on(Arguments& arguments, std::optional<judge::Severity>& fail_on,
                     bool* is_given = nullptr);

}  // namespace vdrive::tool
