// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/periodic_thread.hpp"
#include "presence/discovery.hpp"
#include "streams/status_stream.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/outcome.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <vector>

namespace vdrive::client {

/// Reports what axes show to the program, in a thread of its own and at a rate of its own. Not
/// thread-safe.
class StatusWatcher {
 public:
  using Observer = std::function<void(const Observation&)>;
  using Ended = std::function<void(const Outcome&)>;

  StatusWatcher(const Discovery& discovery, StatusStream& stream)
      : discovery_(discovery), stream_(stream) {}

  /// Session::on_status.
  /// @param axes by bench
  void watch(const std::map<std::uint32_t, std::vector<std::uint16_t>>& axes,
             std::chrono::milliseconds period, Observer observer, Ended ended);

  /// Ends the reports.
  void stop() { thread_.stop(); }

 private:
  struct Bench;

  /// @return whether the reports of the bench continue.
  bool report(Bench& bench, const Observer& observe, const Ended& ended) const;
  [[nodiscard]] bool is_absent_for_good(Bench& bench) const;

  const Discovery& discovery_;
  StatusStream& stream_;
  PeriodicThread thread_;
};

}  // namespace vdrive::client
