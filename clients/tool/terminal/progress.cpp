// SPDX-License-Identifier: Apache-2.0
#include "terminal/progress.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace vdrive::tool {
namespace {

// What is shorter needs no line.
constexpr std::chrono::seconds kBeforeTheFirst{1};
constexpr std::chrono::milliseconds kBetween{250};

}  // namespace

void Progress::tell(Text text) {
  end();
  thread_ = std::jthread([this, text = std::move(text)](const std::stop_token& stop) {
    show(stop, text);
  });
}

void Progress::end() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  terminal_.end_progress();
}

void Progress::show(const std::stop_token& stop, const Text& text) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  const auto is_over_after = [&](std::chrono::milliseconds time) {
    // Nothing but the stop wakes it.
    stopped.wait_for(lock, stop, time, [] {
      return false;
    });
    return stop.stop_requested();
  };
  for (bool is_over = is_over_after(kBeforeTheFirst); !is_over; is_over = is_over_after(kBetween)) {
    terminal_.show_progress(text());
  }
}

}  // namespace vdrive::tool
