// SPDX-License-Identifier: Apache-2.0
#include "inbox.hpp"

#include <cstddef>
#include <utility>

namespace vdrive::ros2 {
namespace {

// More than half a second of commands at 100 Hz. A trajectory may have 4 MB: what waits is
// bounded.
constexpr std::size_t kMostMessages = 64;

}  // namespace

void Inbox::put(Received received) {
  const std::scoped_lock lock(mutex_);
  if (content_.messages.size() >= kMostMessages) {
    content_.messages.pop_front();
    ++content_.dropped;
  }
  content_.messages.push_back(std::move(received));
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
  return std::exchange(content_, {});
}

void Inbox::wait(std::chrono::milliseconds duration, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  woken_.wait_for(lock, stop, duration, [this] {
    return is_woken_;
  });
  is_woken_ = false;
}

}  // namespace vdrive::ros2
