// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::wire {

/// @return the output of `--version` of a program with DDS: "vdrive 1.0.0 (commit 1a2b3c4d5e6f,
///         Fast DDS 2.9.1)". If the source is not a git checkout, "release" replaces the commit.
[[nodiscard]] std::string program_version(const std::string& program);

}  // namespace vdrive::wire
