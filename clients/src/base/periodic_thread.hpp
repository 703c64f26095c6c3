// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

namespace vdrive::client {

/// Work done repeatedly.
/// @return wall time until the next run; nothing = no further run.
using PeriodicWork = std::function<std::optional<std::chrono::milliseconds>()>;

/// Runs `work` until it asks for no further run, or a stop is requested.
inline void work_periodically(const std::stop_token& stop, const PeriodicWork& work) {
  // Never notified: only the stop token ends the sleep early.
  std::condition_variable_any sleep;
  std::mutex mutex;
  std::unique_lock lock(mutex);
  while (!stop.stop_requested()) {
    const auto pause = work();
    if (!pause) return;
    sleep.wait_for(lock, stop, *pause, [] {
      return false;
    });
  }
}

/// A thread that calls a function repeatedly. Not thread-safe.
class PeriodicThread {
 public:
  /// Starts the thread; a running one is ended first.
  void start(PeriodicWork work) {
    stop();
    thread_ = std::jthread([work = std::move(work)](const std::stop_token& stop) {
      work_periodically(stop, work);
    });
  }

  /// Ends the thread if it is running.
  void stop() { thread_ = {}; }

 private:
  std::jthread thread_;
};

}  // namespace vdrive::client
