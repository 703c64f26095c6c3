// SPDX-License-Identifier: Apache-2.0
#include "service_watcher.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace vdrive::client {
namespace {

constexpr std::chrono::milliseconds kPeriod{5};

}  // namespace

void ServiceWatcher::watch(std::function<void(const ServiceChange&)> observer) {
  thread_ = {};  // ends the last watch
  if (!observer) return;
  stream_.subscribe();
  thread_ = std::jthread([this, observe = std::move(observer)](const std::stop_token& stop) {
    ServiceWatch watch;
    std::condition_variable_any sleep;
    std::mutex sleep_mutex;
    std::unique_lock sleeping(sleep_mutex);
    while (!stop.stop_requested()) {
      for (const ServiceChange& change : discovery_.changes(watch)) observe(change);
      sleep.wait_for(sleeping, stop, kPeriod, [] {
        return false;
      });
    }
  });
}

}  // namespace vdrive::client
