// SPDX-License-Identifier: Apache-2.0
#include "keep_alive.hpp"

#include <chrono>
#include <condition_variable>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPeriod{25};

// While a bench connects anew: its watchdog runs.
constexpr milliseconds kRetry{5};

}  // namespace

void KeepAliveSender::start() {
  std::call_once(started_, [this] {
    thread_ = std::jthread([this](const std::stop_token& stop) {
      run(stop);
    });
  });
}

void KeepAliveSender::stop() {
  thread_ = {};
}

void KeepAliveSender::run(const std::stop_token& stop) {
  std::condition_variable_any sleep;
  std::mutex sleep_mutex;
  std::unique_lock sleeping(sleep_mutex);
  while (!stop.stop_requested()) {
    bool are_all_reached = true;
    for (const BenchKey& key : holdings_.to_keep_alive()) {
      are_all_reached &= connection_.send_keep_alive(key);
    }
    sleep.wait_for(sleeping, stop, are_all_reached ? kPeriod : kRetry, [] {
      return false;
    });
  }
}

}  // namespace vdrive::client
