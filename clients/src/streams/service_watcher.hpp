// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/periodic_thread.hpp"
#include "presence/discovery.hpp"
#include "streams/status_stream.hpp"
#include "vdrive/client/session.hpp"

#include <functional>

namespace vdrive::client {

/// Reports to the program, in a thread of its own, what becomes of services. Not thread-safe.
class ServiceWatcher {
 public:
  ServiceWatcher(const Discovery& discovery, StatusStream& stream)
      : discovery_(discovery), stream_(stream) {}

  /// Session::watch_services.
  void watch(std::function<void(const ServiceChange&)> observer);

 private:
  const Discovery& discovery_;
  StatusStream& stream_;
  PeriodicThread thread_;
};

}  // namespace vdrive::client
