// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/bench_names.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// What a command line may continue with.

/// @return whether an argument is meant as an option: no negative number.
[[nodiscard]] bool is_option(const std::string& argument);

/// @param app the commands
/// @param words of the command line without the program; the last one is completed
/// @return the words in its place, none where a file's name may stand.
[[nodiscard]] std::vector<std::string> candidates(const CLI::App& app,
                                                  const std::vector<std::string>& words,
                                                  const BenchNames& names);

/// @return the shells that shell_completion() knows.
[[nodiscard]] std::vector<std::string> completed_shells();

/// @return a script for this shell that completes command lines: it calls the program.
[[nodiscard]] std::string shell_completion(std::string_view shell);

}  // namespace vdrive::tool
