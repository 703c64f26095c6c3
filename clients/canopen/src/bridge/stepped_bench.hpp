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

/// A bench in lock-step, behind its nodes, on which each SYNC lets one period pass: the nodes send
/// what was sampled at SYNC n, the set-points that came before it are handed over in one frame,
/// time passes, and the nodes get the new states. Between two SYNCs time stands, and what the nodes
/// ask of their drives is carried out at once. For the thread of the bus, which waits for the
/// bench: it has no other thread.
class SteppedBench final : private NodeDrives {
 public:
  /// Wall time that a SYNC waits for other steppers of the clock. After it time has not passed, and
  /// the next SYNC continues.
  static constexpr std::chrono::milliseconds kStepPatience{1'000};

  /// @param parts all outlive this
  /// @param places one for each axis of `info`, in their order
  /// @param period drive time of a SYNC
  SteppedBench(const BusParts& parts, const client::BenchInfo& info,
               std::span<const NodePlace> places, std::string label,
               std::chrono::microseconds period);
  ~SteppedBench() override;
  SteppedBench(const SteppedBench&) = delete;
  SteppedBench& operator=(const SteppedBench&) = delete;

  /// @return why time of this bench cannot pass by SYNC; nothing when it can.
  [[nodiscard]] static std::optional<std::string> refusal_of(const client::BenchInfo& info,
                                                             std::chrono::microseconds period);

  /// Joins the clock of the bench and boots the nodes, unless both are done; of a bench that is
  /// gone, or another run, the nodes leave the bus first.
  /// @param present nullptr = the bench is not there
  void poll(const client::BenchInfo* present);

  [[nodiscard]] const BenchNodes& nodes() const noexcept { return nodes_; }

  /// As BenchNodes::note_refused_set_points().
  void note_refused_set_points(std::uint16_t axis, std::uint64_t count) {
    nodes_.note_refused_set_points(axis, count);
  }

 private:
  void access(std::size_t place, const DriveAccess& access) override;
  void tell_connection(std::size_t place, bool is_lost) override;
  void cycle_power(std::size_t place) override;

  void note_set_points() override {}  // they are handed over at SYNC

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
  const std::uint64_t ticks_;  ///< of a SYNC
  const std::chrono::microseconds tick_period_;
  bridge::BenchControl control_;
  std::uint64_t incarnation_ = 0;  ///< of the run whose nodes are there
  std::vector<client::Axis> axes_;
  std::optional<client::StepClock> clock_;
  std::optional<client::Follower> follower_;
  client::Observation sample_;  ///< its memory is used again
  std::uint64_t reached_ = 0;   ///< tick of the bench
  std::uint64_t aim_ = 0;       ///< tick at the end of the SYNC under way, or of the last one
  BenchNodes nodes_;
};

}  // namespace vdrive::canopen
