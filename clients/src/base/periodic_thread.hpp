// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>

namespace vdrive::client {

/// What is done again and again. @return wall time until the next time; nothing = there is none.
using PeriodicWork = std::function<std::optional<std::chrono::milliseconds>()>;

/// Works until there is no next time, or a stop is requested.
void work_periodically(const std::stop_token& stop, const PeriodicWork& work);

/// A thread that calls a function again and again. Not thread-safe.
class PeriodicThread {
 public:
  /// Starts the thread; one that runs already ends first.
  void start(PeriodicWork work);

  /// Ends the thread, if it runs.
  void stop() { thread_ = {}; }

 private:
  std::jthread thread_;
};

}  // namespace vdrive::client
