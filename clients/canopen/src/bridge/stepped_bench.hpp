// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_control.hpp"
#include "bridge/bench_drives.hpp"
#include "bridge/bench_nodes.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/step_clock.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::canopen {

/// Connects nodes to a lock-step bench on which each SYNC advances time by one period: the nodes
/// send the values sampled at SYNC n, the set-points received before it are handed over in one
/// frame, time passes, and the nodes get the new states. Between two SYNCs time stands still, and
/// requests of the nodes to their drives are carried out immediately. For the thread of the bus,
/// which is blocked while it waits for the bench.
class SteppedBench final : private NodeDrives {
 public:
  /// Wall time that a SYNC waits for other steppers of the clock. If they take longer, time has not
  /// passed, and the next SYNC continues the step.
  static constexpr std::chrono::milliseconds kStepPatience{1'000};

  /// @param parts all outlive this object
  /// @param places one for each axis of `info`, in the same order
  /// @param period drive time that a SYNC advances
  SteppedBench(const BusParts& parts, const client::BenchInfo& info,
               std::span<const NodePlace> places, std::string label,
               std::chrono::microseconds period);
  ~SteppedBench() override;
  SteppedBench(const SteppedBench&) = delete;
  SteppedBench& operator=(const SteppedBench&) = delete;

  /// @return why SYNC cannot advance the time of this bench; nothing if it can.
  [[nodiscard]] static std::optional<std::string> refusal_of(const client::BenchInfo& info,
                                                             std::chrono::microseconds period);

  /// Joins the clock of the bench and boots the nodes, if not yet done. If the bench is gone or has
  /// been restarted, the nodes leave the bus first.
  /// @param present nullptr = the bench is absent
  void poll(const client::BenchInfo* present);

  [[nodiscard]] const BenchNodes& nodes() const noexcept { return nodes_; }

  /// See BenchNodes::note_refused_set_points().
  void note_refused_set_points(std::uint16_t axis, std::uint64_t count) {
    nodes_.note_refused_set_points(axis, count);
  }

 private:
  void access(std::size_t place, const DriveAccess& access) override;
  void tell_connection(std::size_t place, bool is_lost) override;
  void cycle_power(std::size_t place) override;

  void note_set_points() override {}  // handed over at SYNC

  void read(std::size_t place, std::uint32_t ticket,
            const std::vector<ObjectAddress>& objects) override;
  void pass_sync() override;
  [[nodiscard]] client::Outcome open();
  [[nodiscard]] client::Outcome join();
  void close(const std::string& reason);
  [[nodiscard]] client::Outcome step();
  void hand_over();
  void note_failure(const client::Outcome& outcome, const char* what);
  [[nodiscard]] DriveTime time_of(const client::Observation& observation) const;

  const BusParts parts_;
  const std::uint32_t bench_;
  const std::vector<client::AxisId> ids_;
  const std::string label_;
  const std::uint64_t ticks_;  ///< ticks per SYNC
  const std::chrono::microseconds tick_period_;
  bridge::BenchControl control_;
  std::uint64_t incarnation_ = 0;  ///< of the bench run to which the present nodes belong
  std::vector<client::Axis> axes_;
  std::optional<client::StepClock> clock_;
  std::optional<client::Follower> follower_;
  client::Observation sample_;  ///< kept to reuse its memory
  std::uint64_t reached_ = 0;   ///< tick of the bench
  std::uint64_t aim_ = 0;       ///< last tick of the current or latest SYNC
  BenchNodes nodes_;
};

}  // namespace vdrive::canopen
