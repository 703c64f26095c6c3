// SPDX-License-Identifier: Apache-2.0
#include "base/periodic_thread.hpp"

#include <condition_variable>
#include <mutex>
#include <utility>

namespace vdrive::client {

void work_periodically(const std::stop_token& stop, const PeriodicWork& work) {
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

void PeriodicThread::start(PeriodicWork work) {
  stop();
  thread_ = std::jthread([work = std::move(work)](const std::stop_token& stop) {
    work_periodically(stop, work);
  });
}

}  // namespace vdrive::client
