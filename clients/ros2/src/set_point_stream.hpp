// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "joint_plan.hpp"
#include "set_point_lead.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::ros2 {

/// What is sent as set-points: the frames that the plans of a bench need, for the ticks that they
/// can still reach. What was sent stays: a new motion begins after it.
class SetPointStream {
 public:
  using Frames = std::vector<client::SetPointFrame>;

  /// @param plans outlives this
  SetPointStream(const client::BenchInfo& bench, double period, JointPlans& plans)
      : lead_(bench.clock_mode, period), plans_(plans) {}

  /// @param rate drive time over wall time
  void set_rate(double rate) noexcept { lead_.set_rate(rate); }

  /// @return whether set-points are on their way, and go on.
  [[nodiscard]] bool is_running() const;

  /// @return the last tick that has set-points.
  [[nodiscard]] std::uint64_t sent_until() const noexcept { return sent_until_; }

  /// Chooses sent_until() for a motion that begins behind it. For a stream that was not running
  /// before: what runs goes on where it is.
  /// @param tick of the newest state
  /// @param wanted a later tick, taken when it is near
  void begin(std::uint64_t tick, std::uint64_t wanted = 0);

  /// A set-point came too late: what follows keeps a larger distance.
  void lengthen() noexcept { lead_.lengthen(); }

  /// The bench has passed the last set-point: what follows begins after `tick`, with a larger
  /// distance.
  void catch_up(std::uint64_t tick);

  /// Nothing is on its way any more.
  void clear() noexcept { sent_until_ = 0; }

  /// @return the modes that joints wait for; those whose drive is in it begin.
  [[nodiscard]] Frames modes(const BenchNow& now);

  /// @return set-points up to the tick that they are sent ahead for.
  [[nodiscard]] Frames points(const BenchNow& now);

 private:
  SetPointLead lead_;
  JointPlans& plans_;
  std::uint64_t sent_until_ = 0;
};

}  // namespace vdrive::ros2
