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

/// What is done again and again. @return wall time until the next time; nothing = there is none.
using PeriodicWork = std::function<std::optional<std::chrono::milliseconds>()>;

/// Works until there is no next time, or a stop is requested.
inline void work_periodically(const std::stop_token& stop, const PeriodicWork& work) {
  // Never notified: a sleep that the stop token ends.
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

/// A thread that calls a function again and again. Not thread-safe.
class PeriodicThread {
 public:
  /// Starts the thread; one that runs already ends first.
  void start(PeriodicWork work) {
    stop();
    thread_ = std::jthread([work = std::move(work)](const std::stop_token& stop) {
      work_periodically(stop, work);
    });
  }

  /// Ends the thread, if it runs.
  void stop() { thread_ = {}; }

 private:
  std::jthread thread_;
};

}  // namespace vdrive::client
