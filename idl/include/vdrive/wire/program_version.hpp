// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::wire {

/// @return what `--version` of a program over DDS shows: "vdrive 1.0.0 (commit 1a2b3c4d5e6f, Fast
/// DDS
///         2.9.1)". In the place of the commit stands "release" where the source is no git
///         checkout.
[[nodiscard]] std::string program_version(const std::string& program);

}  // namespace vdrive::wire
