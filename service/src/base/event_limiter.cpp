// SPDX-License-Identifier: Apache-2.0
#include "base/event_limiter.hpp"

#include <utility>

namespace vdrive::service {

void EventLimiter::offer(const EventRecord& event, std::chrono::nanoseconds now,
                         std::vector<CountedEvent>& passed) {
  if (windows_.size() >= kMostKinds) {
    for (const auto& [key, window] : windows_) forgotten_ += window.limit.left_out();
    windows_.clear();
  }
  const Key key{event.kind, event.axis, event.code, event.session};
  Window& window = windows_.try_emplace(key, Window{.begin = now}).first->second;
  all_.refill(now);
  if (all_.is_empty()) {
    window.limit.leave_out();
  } else if (const auto left_out = window.limit.pass(now)) {
    static_cast<void>(all_.take());
    passed.push_back({event, *left_out + std::exchange(forgotten_, 0)});
    return;
  }
  window.last = event;
}

void EventLimiter::flush(std::chrono::nanoseconds now, std::vector<CountedEvent>& passed) {
  std::erase_if(windows_, [&](const auto& entry) {
    const Window& window = entry.second;
    if (now - window.begin < kWindow) return false;
    if (const std::uint64_t left_out = window.limit.left_out(); left_out > 0) {
      passed.push_back({window.last, left_out - 1});
    }
    return true;
  });
}

}  // namespace vdrive::service
