// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "joint_plan.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::ros2 {

/// The published data of a bench: its newest state, once the set-points for the following ticks
/// have been sent.
struct BenchView {
  std::shared_ptr<const Bench> bench{};  ///< without joints if the bridge does not serve it
  Bench::State state{};                  ///< null while the bench sends no status
  Bench::Limits limits{};
  std::shared_ptr<const Bench::Names> names{};
  std::vector<JointTask> tasks{};
  bool is_enabled = false;
  std::uint64_t session = 0;  ///< of the bridge
  std::string problem{};      ///< why the bridge does not serve the bench; empty = it does
};

/// Passes the views from the commanding thread to the publishing one.
class Board {
 public:
  using Views = std::map<std::uint32_t, BenchView>;

  /// @param is_urgent whether to wake the publisher; otherwise it checks at its own times
  void put(Views views, bool is_urgent) {
    const std::scoped_lock lock(mutex_);
    views_ = std::move(views);
    if (!is_urgent) return;
    is_new_ = true;
    changed_.notify_all();
  }

  [[nodiscard]] Views views() const {
    const std::scoped_lock lock(mutex_);
    return views_;
  }

  /// Waits for new views, at most until `time`.
  void wait_until(std::chrono::steady_clock::time_point time, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, stop, time, [this] {
      return is_new_;
    });
    is_new_ = false;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  Views views_;
  bool is_new_ = false;
};

}  // namespace vdrive::ros2
