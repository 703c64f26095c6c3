// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judge.hpp"

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::judge {

/// The result of judging a journal of a bench.
struct JournalVerdict {
  Verdict verdict;
  std::uint32_t bench = 0;         ///< its number
  std::vector<std::string> notes;  ///< what the journal lacks, one per line
};

/// @return whether `source` begins like a journal. Does not consume any input.
[[nodiscard]] bool is_journal(std::istream& source);

/// Replays the drives of a journal, as `vdrived --replay` does, and judges the masters by their
/// writes and by the state that these drives showed in each tick.
/// @param threads that step the drives; nothing = as many as the bench had
/// @throws std::runtime_error if it cannot be read to the end or replayed: it is damaged, was
///         written by a version with another state layout, or the check of a tick differs
[[nodiscard]] JournalVerdict judge_journal(std::istream& journal,
                                           std::optional<std::uint32_t> threads = {});

}  // namespace vdrive::judge
