// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::wire {

/// @return name and version of the DDS library whose headers this build has: "Fast DDS 2.9.1".
[[nodiscard]] std::string library_version();

}  // namespace vdrive::wire
