// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::wire {

/// @return name and version of the DDS library that this build was compiled for: "Fast DDS 2.9.1".
[[nodiscard]] std::string library_version();

}  // namespace vdrive::wire
