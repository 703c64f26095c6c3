// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"

namespace vdrive::tool {

/// Checks what the dictionary of this tool knows about a line of a scenario: that its objects
/// exist, that what is written may be written and is within its range, and that an expected value
/// is possible. A command of which a refusal is expected is not checked.
/// @throws UsageError naming object, value and limits.
void check_objects(const Command& command);

}  // namespace vdrive::tool
