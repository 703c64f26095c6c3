// SPDX-License-Identifier: Apache-2.0
#include "base/periodic_thread.hpp"

#include <condition_variable>
#include <mutex>
#include <utility>

namespace vdrive::client {

void ReportThread::start(Work work) {
  stop();
  thread_ = std::jthread(std::move(work));
}

void ReportThread::stop() {
  const auto self = std::this_thread::get_id();
  thread_.request_stop();
  if (thread_.get_id() == self) {
    ended_.push_back(std::move(thread_));
  } else {
    thread_ = {};
  }
  std::erase_if(ended_, [self](const std::jthread& ended) {
    return ended.get_id() != self;
  });
}

void PeriodicThread::start(Work work) {
  thread_.start([work = std::move(work)](const std::stop_token& stop) {
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
  });
}

}  // namespace vdrive::client
