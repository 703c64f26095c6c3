// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"

namespace vdrive::tool {

/// @return all commands of the tool, in the order of its help.
[[nodiscard]] CommandTable commands();

}  // namespace vdrive::tool
