// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/rule.hpp"
#include "language/arguments.hpp"

#include <optional>

namespace vdrive::tool {

/// --fail-on SEVERITY: which findings are failures. @param fail_on nothing = none
void declare_fail_on(Arguments& arguments, std::optional<judge::Severity>& fail_on);

}  // namespace vdrive::tool
