// SPDX-License-Identifier: Apache-2.0
#include "bridge/refused_set_points.hpp"

#include <utility>

namespace vdrive::canopen {

RefusedSetPoints::RefusedSetPoints(std::function<void()> notify) : notify_(std::move(notify)) {}

void RefusedSetPoints::note(const client::SetPointRefusal& refusal) {
  {
    const std::scoped_lock lock(mutex_);
    const bool is_first = counts_.empty();
    ++counts_[refusal];
    if (!is_first) return;
  }
  notify_();
}

std::vector<RefusedSetPoints::Count> RefusedSetPoints::take() {
  std::map<client::SetPointRefusal, std::uint64_t> counts;
  {
    const std::scoped_lock lock(mutex_);
    counts.swap(counts_);
  }
  std::vector<Count> taken;
  taken.reserve(counts.size());
  for (const auto& [refusal, count] : counts) taken.push_back({.refusal = refusal, .count = count});
  return taken;
}

}  // namespace vdrive::canopen
