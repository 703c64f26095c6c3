// SPDX-License-Identifier: Apache-2.0
#include "streams/service_watcher.hpp"

#include "base/periodic_thread.hpp"

#include <chrono>
#include <optional>
#include <utility>

namespace vdrive::client {
namespace {

// A change is reported within 100 ms: the silence that shows it takes 80 ms, see service_watch.cpp.
constexpr std::chrono::milliseconds kWatchPeriod{5};

}  // namespace

void ServiceWatcher::watch(std::function<void(const ServiceChange&)> observer) {
  thread_.stop();
  if (!observer) return;
  stream_.subscribe();
  thread_.start([this, observe = std::move(observer),
                 watch = ServiceWatch()](const std::stop_token& stop) mutable {
    work_periodically(stop, [&]() -> std::optional<std::chrono::milliseconds> {
      const bool continues = failure_.run([&] {
        for (const ServiceChange& change : discovery_.changes(watch)) {
          if (stop.stop_requested()) return;
          observe(change);
        }
      });
      return continues ? std::optional(kWatchPeriod) : std::nullopt;
    });
  });
}

}  // namespace vdrive::client
