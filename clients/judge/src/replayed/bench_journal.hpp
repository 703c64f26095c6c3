// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judge.hpp"

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::judge {

/// What the journal of a bench gives.
struct JournalVerdict {
  Verdict verdict;
  std::uint32_t bench = 0;         ///< its number
  std::vector<std::string> notes;  ///< what the journal lacks, a line each
};

/// @return whether `source` begins as a journal does. Reads nothing.
[[nodiscard]] bool is_journal(std::istream& source);

/// Runs the drives of a journal again, as `vdrived --replay` does, and judges the masters by what
/// they wrote and what these drives showed in each tick.
/// @param threads that step the drives; nothing = as many as the bench had
/// @throws std::runtime_error when it cannot be read to its end or replayed: it is damaged, was
///         written by a version whose state has another layout, or a check of a tick differs
[[nodiscard]] JournalVerdict judge_journal(std::istream& journal,
                                           std::optional<std::uint32_t> threads = {});

}  // namespace vdrive::judge
