// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/report_thread.hpp"
#include "presence/discovery.hpp"
#include "streams/status_stream.hpp"
#include "vdrive/client/session.hpp"

#include <functional>

namespace vdrive::client {

/// Reports to the program, in a thread of its own, what becomes of services. Thread-safe.
class ServiceWatcher {
 public:
  ServiceWatcher(const Discovery& discovery, StatusStream& stream, ObserverFailure& failure,
                 ReportThreads& threads)
      : discovery_(discovery), stream_(stream), failure_(failure), thread_(threads) {}

  /// Session::watch_services.
  void watch(std::function<void(const ServiceChange&)> observer);

 private:
  const Discovery& discovery_;
  StatusStream& stream_;
  ObserverFailure& failure_;
  ReportThread thread_;
};

}  // namespace vdrive::client
