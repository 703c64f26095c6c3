// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/report_queue.hpp"
#include "base/report_thread.hpp"
#include "exchange/bench_links.hpp"
#include "vdrive/client/session.hpp"

#include <cstddef>
#include <functional>
#include <memory>

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
  /// A program may count them: 256 frames of 256 values each fit.
  static constexpr std::size_t kMostWaiting = 65'536;
  using Waiting = ReportQueue<SetPointRefusal, kMostWaiting>;

  BenchLinks& links_;
  ObserverFailure& failure_;
  /// Of all watches: whichever thread remains of two that begin at once has what arrives.
  std::shared_ptr<Waiting> waiting_ = std::make_shared<Waiting>();
  ReportThread thread_;
};

}  // namespace vdrive::client
