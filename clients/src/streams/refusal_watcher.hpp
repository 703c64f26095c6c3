// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/report_thread.hpp"
#include "exchange/bench_links.hpp"
#include "vdrive/client/session.hpp"

#include <functional>

namespace vdrive::client {

/// Reports to the program, in a thread of its own, the values of set-points that drives refuse.
/// Thread-safe.
class RefusalWatcher {
 public:
  RefusalWatcher(BenchLinks& links, ObserverFailure& failure, ReportThreads& threads)
      : links_(links), failure_(failure), thread_(threads) {}

  /// Session::on_set_point_refusal.
  void watch(std::function<void(const SetPointRefusal&)> observer);

 private:
  BenchLinks& links_;
  ObserverFailure& failure_;
  ReportThread thread_;
};

}  // namespace vdrive::client
