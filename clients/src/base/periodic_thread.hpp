// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace vdrive::client {

/// A thread that calls a function again and again. Not thread-safe; its end waits for a call that
/// is under way.
class PeriodicThread {
 public:
  /// @return wall time until the next call.
  using Work = std::function<std::chrono::milliseconds()>;

  /// Starts the thread; one that runs already ends first.
  void start(Work work);

  /// Ends the thread, if it runs.
  void stop() { thread_ = {}; }

 private:
  std::jthread thread_;
};

}  // namespace vdrive::client
