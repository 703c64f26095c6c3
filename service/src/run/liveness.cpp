// SPDX-License-Identifier: Apache-2.0
#include "run/liveness.hpp"

#include <algorithm>

namespace vdrive::service {

Liveness::Liveness(const std::vector<const Counter*>& beats) {
  for (const Counter* const counter : beats) watched_.push_back({.beats = counter});
}

bool Liveness::has_begun() const noexcept {
  return !watched_.empty() && std::ranges::all_of(watched_, [](const Watched& watched) {
    return watched.beats->get() > 0;
  });
}

bool Liveness::has_advanced() noexcept {
  bool advanced = !watched_.empty();
  for (Watched& watched : watched_) {
    const std::uint64_t now = watched.beats->get();
    advanced = advanced && now != watched.seen;
    watched.seen = now;
  }
  return advanced;
}

}  // namespace vdrive::service
