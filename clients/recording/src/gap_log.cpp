// SPDX-License-Identifier: Apache-2.0
#include "gap_log.hpp"

#include "vdrive/wording.hpp"

#include <algorithm>

namespace vdrive::recording {
namespace {

std::string text_of_gap(const Gap& gap) {
  const std::string where = gap.before == 0 ? "after the tick " + std::to_string(gap.after)
                                            : "between the ticks " + std::to_string(gap.after) +
                                                  " and " + std::to_string(gap.before);
  return where + " of bench " + std::to_string(gap.bench) + " (" + std::to_string(gap.missed) + ")";
}

}  // namespace

void GapLog::note_sample(std::uint32_t bench, std::uint64_t tick, std::uint64_t missed) {
  if (missed != 0) {
    const auto last = last_ticks_.find(bench);
    add({.bench = bench,
         .after = last == last_ticks_.end() ? 0 : last->second,
         .before = tick,
         .missed = missed});
  }
  last_ticks_[bench] = tick;
}

void GapLog::note_lost_end(std::uint32_t bench, std::uint64_t missed) {
  if (missed == 0) return;
  const auto last = last_ticks_.find(bench);
  add({.bench = bench,
       .after = last == last_ticks_.end() ? 0 : last->second,
       .before = 0,
       .missed = missed});
}

void GapLog::add(const Gap& gap) {
  missed_ += gap.missed;
  if (gaps_.size() < kKept) {
    gaps_.push_back(gap);
  } else {
    ++left_out_;
  }
}

std::string GapLog::text(std::size_t most) const {
  std::string text;
  const std::size_t named = std::min(most, gaps_.size());
  for (std::size_t i = 0; i < named; ++i) {
    if (i != 0) text += ", ";
    text += text_of_gap(gaps_[i]);
  }
  const std::uint64_t others = gaps_.size() - named + left_out_;
  if (others != 0) text += ", and " + counted(others, "further gap", "further gaps");
  return text;
}

}  // namespace vdrive::recording
