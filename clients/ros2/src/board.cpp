// SPDX-License-Identifier: Apache-2.0
#include "board.hpp"

#include <utility>

namespace vdrive::ros2 {

void Board::put(Views views, bool is_urgent) {
  const std::scoped_lock lock(mutex_);
  views_ = std::move(views);
  if (!is_urgent) return;
  is_new_ = true;
  changed_.notify_all();
}

Board::Views Board::views() const {
  const std::scoped_lock lock(mutex_);
  return views_;
}

void Board::wait_until(std::chrono::steady_clock::time_point time, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, time, [this] {
    return is_new_;
  });
  is_new_ = false;
}

}  // namespace vdrive::ros2
