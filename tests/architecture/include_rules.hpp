// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vdrive::architecture {

/// One broken rule, as "core/src/axis.cpp:12: <thread>: core/ has no threads".
using Violations = std::vector<std::string>;

/// Checks one source file against the table of rooms in docs/architecture.md: who may include whom,
/// and what a room may never contain.
/// @param path relative to the repository, with forward slashes; its first part is the room. A file
///        in no room (or in tests/, which may include everything) has no violations.
/// @param text the content of the file.
Violations check_source(std::string_view path, std::string_view text);

/// Whether a file may include a private header: one of its own room, or of service/src/settings,
/// which all rooms share. The rooms that run the engine may include any of service/src.
/// @param included the header as the file names it
/// @param headers all headers of the repository, by their paths
[[nodiscard]] bool reaches_private_header(std::string_view path, std::string_view included,
                                          const std::vector<std::string>& headers);

/// Checks the names at the top of the repository: exactly the rooms and the few files next to them.
/// Names that start with a dot and `build` are not checked.
Violations check_top_level(const std::vector<std::string>& names);

}  // namespace vdrive::architecture
