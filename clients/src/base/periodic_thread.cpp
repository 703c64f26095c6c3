// SPDX-License-Identifier: Apache-2.0
#include "base/periodic_thread.hpp"

#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <utility>

namespace vdrive::client {

void PeriodicThread::start(Work work) {
  stop();
  thread_ = std::jthread([work = std::move(work)](const std::stop_token& stop) {
    // Never notified: a sleep that the stop token ends.
    std::condition_variable_any sleep;
    std::mutex mutex;
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      sleep.wait_for(lock, stop, work(), [] {
        return false;
      });
    }
  });
}

}  // namespace vdrive::client
