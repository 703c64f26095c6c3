// SPDX-License-Identifier: Apache-2.0
#include "base/event_limiter.hpp"

#include <utility>

namespace vdrive::service {

void EventLimiter::offer(const EventRecord& event, std::chrono::nanoseconds now,
                         std::vector<CountedEvent>& passed) {
  if (now - begin_ >= kWindow) {
    begin_ = now;
    passed_ = 0;
  }
  if (windows_.size() >= kMostKinds) {
    for (const auto& [key, window] : windows_) suppressed_ += window.suppressed;
    windows_.clear();
  }
  Window& window = windows_[{event.kind, event.axis, event.code, event.session}];
  if (window.passed == 0 || now - window.begin >= kWindow) {
    window.begin = now;
    window.passed = 0;
  }
  if (window.passed >= kEqualPerWindow || passed_ >= kAllPerWindow) {
    ++window.suppressed;
    window.last = event;
    return;
  }
  ++window.passed;
  ++passed_;
  passed.push_back({event, std::exchange(window.suppressed, 0) + std::exchange(suppressed_, 0)});
}

void EventLimiter::flush(std::chrono::nanoseconds now, std::vector<CountedEvent>& passed) {
  std::erase_if(windows_, [&](const auto& entry) {
    const Window& window = entry.second;
    if (now - window.begin < kWindow) return false;
    if (window.suppressed > 0) {  // the last of them is reported, with the count of the others
      passed.push_back({window.last, window.suppressed - 1});
    }
    return true;
  });
}

}  // namespace vdrive::service
