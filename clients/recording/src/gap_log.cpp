// SPDX-License-Identifier: Apache-2.0
#include "gap_log.hpp"

#include "vdrive/wording.hpp"

#include <algorithm>
#include <string_view>

namespace vdrive::recording {
namespace {

/// Such as "between the ticks 12 and 15 of bench 1 (2)".
std::string place_of(std::uint32_t bench, std::uint64_t after, std::uint64_t before,
                     std::uint64_t count) {
  const std::string where =
      before == 0 ? "after the tick " + std::to_string(after)
                  : "between the ticks " + std::to_string(after) + " and " + std::to_string(before);
  return where + " of bench " + std::to_string(bench) + " (" + std::to_string(count) + ")";
}

std::string place_of(const Gap& gap) {
  return place_of(gap.bench, gap.after, gap.before, gap.missed);
}

std::string place_of(const Jump& jump) {
  return place_of(jump.bench, jump.after, jump.before, jump.skipped);
}

/// The first ones, then how many others there are.
template <typename Entry>
std::string list_of(const std::vector<Entry>& entries, std::size_t most, std::uint64_t left_out,
                    std::string_view one, std::string_view many) {
  std::string text;
  const std::size_t named = std::min(most, entries.size());
  for (std::size_t i = 0; i < named; ++i) {
    if (i != 0) text += ", ";
    text += place_of(entries[i]);
  }
  const std::uint64_t others = entries.size() - named + left_out;
  if (others != 0) text += ", and " + counted(others, one, many);
  return text;
}

}  // namespace

void GapLog::note_sample(const client::Observation& sample) {
  const std::uint32_t bench = sample.axes.front().id.bench;
  const auto last = last_ticks_.find(bench);
  const std::uint64_t after = last == last_ticks_.end() ? 0 : last->second;
  if (sample.missed != 0) {
    add(Gap{.bench = bench, .after = after, .before = sample.tick, .missed = sample.missed});
  }
  if (sample.skipped != 0) {
    add(Jump{.bench = bench, .after = after, .before = sample.tick, .skipped = sample.skipped});
  }
  last_ticks_[bench] = sample.tick;
}

void GapLog::note_lost_end(std::uint32_t bench, std::uint64_t missed) {
  if (missed == 0) return;
  const auto last = last_ticks_.find(bench);
  add(Gap{.bench = bench,
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

void GapLog::add(const Jump& jump) {
  skipped_ += jump.skipped;
  if (jumps_.size() < kKept) {
    jumps_.push_back(jump);
  } else {
    ++jumps_left_out_;
  }
}

std::string GapLog::text(std::size_t most) const {
  return list_of(gaps_, most, left_out_, "further gap", "further gaps");
}

std::string GapLog::jumps_text(std::size_t most) const {
  return list_of(jumps_, most, jumps_left_out_, "further jump", "further jumps");
}

}  // namespace vdrive::recording
