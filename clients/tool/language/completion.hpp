// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/arguments.hpp"
#include "language/bench_names.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {

/// What a command line may continue with.

/// @return whether an argument is meant as an option: no negative number.
[[nodiscard]] bool is_option(const std::string& argument);

/// @param app the commands
/// @param completers of their arguments
/// @param words of the command line without the program; the last one is completed
/// @return the words in its place, none where a file's name may stand.
[[nodiscard]] std::vector<std::string> candidates(const CLI::App& app, const Completers& completers,
                                                  const std::vector<std::string>& words,
                                                  const BenchNames& names);

}  // namespace vdrive::tool
