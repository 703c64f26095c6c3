// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/periodic_thread.hpp"
#include "exchange/bench_links.hpp"
#include "exchange/holdings.hpp"

#include <chrono>
#include <mutex>

namespace vdrive::client {

/// Sends keep-alives, in a thread of its own, to the benches that take axes away from a silent
/// session.
class KeepAliveSender {
 public:
  KeepAliveSender(const Holdings& holdings, BenchLinks& links)
      : holdings_(holdings), links_(links) {}

  /// Starts the thread, once.
  void start();

  /// Ends the thread. It must not be started at the same time.
  void stop() { thread_.stop(); }

 private:
  /// @return wall time until the next ones.
  [[nodiscard]] std::chrono::milliseconds send();

  const Holdings& holdings_;
  BenchLinks& links_;
  std::once_flag started_;
  PeriodicThread thread_;
};

}  // namespace vdrive::client
