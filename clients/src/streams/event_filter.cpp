// SPDX-License-Identifier: Apache-2.0
#include "streams/event_filter.hpp"

#include <algorithm>

namespace vdrive::client {

void EventFilter::begin(const BenchKey& key, std::uint64_t tick) {
  // An earlier run of the bench sends no more events.
  std::erase_if(runs_, [&key](const auto& item) {
    return item.first.number == key.number && item.first.incarnation < key.incarnation;
  });
  runs_.try_emplace(key, Run{.first_tick = tick, .passed = {}});
}

bool EventFilter::passes(const msg::Event& event) {
  const auto found = runs_.find({event.bench, event.incarnation});
  if (found == runs_.end() || event.tick < found->second.first_tick) return false;
  std::deque<msg::Event>& passed = found->second.passed;
  if (std::ranges::find(passed, event) != passed.end()) return false;
  if (passed.size() == kRemembered) passed.pop_front();
  passed.push_back(event);
  return true;
}

}  // namespace vdrive::client
