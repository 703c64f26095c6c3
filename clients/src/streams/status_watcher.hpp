// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
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
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace vdrive::client {

/// Reports what axes show to the program, in a thread of its own and at a rate of its own. Not
/// thread-safe.
class StatusWatcher {
 public:
  using Report = std::function<void(const Observation&)>;
  using Ended = std::function<void(const Outcome&)>;

  /// What axes of a bench show now.
  using Look =
      std::function<Result<Observation>(const Target&, std::span<const std::uint16_t> axes)>;

  StatusWatcher(const Discovery& discovery, StatusStream& stream, ObserverFailure& failure,
                Look look)
      : discovery_(discovery), stream_(stream), failure_(failure), look_(std::move(look)) {}

  /// Session::on_status.
  /// @param axes by bench
  void watch(const std::map<std::uint32_t, std::vector<std::uint16_t>>& axes,
             std::chrono::milliseconds period, Report report, Ended ended);

  /// Ends the reports.
  void stop() { thread_.stop(); }

 private:
  struct Bench;

  /// @return whether the reports of the bench continue.
  bool follow(Bench& bench, const Report& report, const Ended& ended) const;
  static void show(Bench& bench, const Observation& seen, const Report& report);
  [[nodiscard]] std::optional<Observation> begin(Bench& bench, const Target& target) const;
  [[nodiscard]] bool is_absent_for_good(Bench& bench) const;

  const Discovery& discovery_;
  StatusStream& stream_;
  ObserverFailure& failure_;
  Look look_;
  PeriodicThread thread_;
};

}  // namespace vdrive::client
