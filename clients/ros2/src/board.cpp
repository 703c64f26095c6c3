// SPDX-License-Identifier: Apache-2.0
#include "board.hpp"

#include "wall_time.hpp"

#include <cstdlib>
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

std::int64_t stamp_of(const client::BenchInfo& bench, std::uint64_t tick) {
  constexpr std::int64_t kDifference = 1'000'000'000;
  const std::int64_t drive_time =
      static_cast<std::int64_t>(tick) * std::chrono::nanoseconds(bench.period).count();
  if (bench.clock_mode != client::ClockMode::realtime) return drive_time;
  const std::int64_t now = bridge::wall_time();
  return std::abs(now - drive_time) < kDifference ? drive_time : now;
}

}  // namespace vdrive::ros2
