// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/report_thread.hpp"
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
#include <stop_token>
#include <utility>
#include <vector>

namespace vdrive::client {

/// Reports what axes show to the program, in threads of their own and at rates of their own.
/// Thread-safe.
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

  /// Session::on_status, in this thread.
  /// @param axes by bench
  void watch(ReportThread& thread, const std::map<std::uint32_t, std::vector<std::uint16_t>>& axes,
             std::chrono::milliseconds period, Report report, Ended ended) const;

 private:
  struct Bench;
  struct Watch;

  void run(Watch& watch, const std::stop_token& stop) const;
  /// @return whether the reports of the bench continue.
  bool follow(Bench& bench, const Watch& watch, const std::stop_token& stop) const;
  static void show(Bench& bench, const Observation& seen, const Report& report);
  [[nodiscard]] std::optional<Observation> begin(Bench& bench, const Target& target) const;
  [[nodiscard]] bool is_absent_for_good(Bench& bench) const;

  const Discovery& discovery_;
  StatusStream& stream_;
  ObserverFailure& failure_;
  Look look_;
};

}  // namespace vdrive::client
