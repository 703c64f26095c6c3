// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "journal/journal_file.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace vdrive::service {

/// What came of a replay.
struct ReplayResult {
  bool agrees = true;       ///< every check that the journal has
  bool is_complete = true;  ///< no tick is missing, and the journal has its end
  std::string text;         ///< one line for people
  std::uint64_t ticks = 0;
  std::uint64_t changes = 0;
};

/// Steps the axes of a journal through what it recorded, as fast as it goes, and compares the check
/// of every tick. No network, no clock.
/// @param threads that step the axes; nothing = as configured in the journal
/// @throws JournalError when the file cannot be read, is damaged, or was written by a program whose
///         state has another layout
[[nodiscard]] ReplayResult replay(const std::filesystem::path& file,
                                  std::optional<std::uint32_t> threads);

}  // namespace vdrive::service
