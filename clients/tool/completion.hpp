// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace vdrive::tool {

/// @return a script that completes command lines of `app` in bash: its words, what they take, and
///         names of files wherever neither fits.
[[nodiscard]] std::string bash_completion(const CLI::App& app);

}  // namespace vdrive::tool
