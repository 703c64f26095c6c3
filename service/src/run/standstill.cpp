// SPDX-License-Identifier: Apache-2.0
#include "run/standstill.hpp"

#include <algorithm>

namespace vdrive::service {

std::vector<const Counter*> counts_of(const std::vector<Beats>& beats) {
  std::vector<const Counter*> counts;
  counts.reserve(beats.size());
  for (const Beats& each : beats) counts.push_back(each.count);
  return counts;
}

Standstill::Standstill(const std::vector<Beats>& beats, Clock::time_point now) {
  for (const Beats& each : beats) {
    watched_.push_back({.beats = each, .seen = each.count->get(), .since = now});
  }
}

Standstill::Longest Standstill::look(Clock::time_point now) {
  for (Watched& watched : watched_) {
    const std::uint64_t count = watched.beats.count->get();
    if (count == watched.seen) continue;
    watched.seen = count;
    watched.since = now;
  }
  const auto oldest = std::ranges::min_element(watched_, {}, &Watched::since);
  return {.name = oldest->beats.name, .time = now - oldest->since};
}

}  // namespace vdrive::service
