// SPDX-License-Identifier: Apache-2.0
#include "inbox.hpp"

#include <utility>

namespace vdrive::ros2 {

void Inbox::put(Received received) {
  const std::scoped_lock lock(mutex_);
  messages_.put(std::move(received));
  is_woken_ = true;
  woken_.notify_one();
}

void Inbox::wake() {
  const std::scoped_lock lock(mutex_);
  is_woken_ = true;
  woken_.notify_one();
}

Inbox::Content Inbox::take() {
  const std::scoped_lock lock(mutex_);
  const std::uint64_t dropped = messages_.dropped();
  return {.messages = messages_.take_all(), .dropped = dropped - std::exchange(reported_, dropped)};
}

void Inbox::wait(std::chrono::milliseconds duration, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  woken_.wait_for(lock, stop, duration, [this] {
    return is_woken_;
  });
  is_woken_ = false;
}

}  // namespace vdrive::ros2
