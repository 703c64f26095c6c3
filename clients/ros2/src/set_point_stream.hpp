// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "joint_plan.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/clock_mode.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::ros2 {

/// How many ticks ahead of a bench its set-points are sent. In lock-step, where the length of the
/// next step is unknown, this does not depend on wall time.
class SetPointLead {
 public:
  /// @param period [s] of a tick
  SetPointLead(ClockMode clock, double period) : clock_(clock), period_(period) {}

  /// @param rate drive time over wall time
  void set_rate(double rate) noexcept { rate_ = rate; }

  /// @return ticks from the newest state to the first one that a new set-point can reach.
  [[nodiscard]] std::uint64_t lead() const;

  /// @return the number of ticks for which set-points are sent in advance during a motion: for a
  ///         trajectory enough to outlast a pause of the machine, for single positions no more than
  ///         needed, because a new position is delayed by them.
  [[nodiscard]] std::uint64_t window(bool is_trajectory) const;

  /// @return the number of ticks before its start at which the stream accepts a trajectory.
  [[nodiscard]] std::uint64_t ahead_of_trajectory() const;

  /// Reacts to late set-points: the machine, or the connection to the bench, is slower than the
  /// lead.
  void lengthen() noexcept;

 private:
  [[nodiscard]] std::uint64_t ticks(double seconds) const;

  ClockMode clock_;
  double period_;
  double rate_ = 1.0;
  double lead_ = kShortest;  ///< [s of wall time]

  /// [s] Some cycles of the controller, so that a late one does not miss its tick.
  static constexpr double kShortest = 0.008;
};

/// The set-points of a bench: the frames that its plans need, for the ticks that can still be
/// reached. What was sent stays in force: a new motion starts after it.
class SetPointStream {
 public:
  using Frames = std::vector<client::SetPointFrame>;

  /// @param plans must outlive this
  SetPointStream(const client::BenchInfo& bench, double period, JointPlans& plans)
      : lead_(bench.clock_mode, period), plans_(plans) {}

  /// @param rate drive time over wall time
  void set_rate(double rate) noexcept { lead_.set_rate(rate); }

  /// @return whether set-points are in flight, and more will follow.
  [[nodiscard]] bool is_running() const;

  /// @return the last tick that has set-points.
  [[nodiscard]] std::uint64_t sent_until() const noexcept { return sent_until_; }

  /// Sets sent_until() for a motion that starts after it. Only for a stream that was not running: a
  /// running one continues where it is.
  /// @param tick of the newest state
  /// @param wanted a later tick, used if it is near
  void begin(std::uint64_t tick, std::uint64_t wanted = 0);

  /// Keeps a larger distance from now on, after a late set-point.
  void lengthen() noexcept { lead_.lengthen(); }

  /// Restarts after the bench has run past the last set-point: new set-points start after `tick`,
  /// with a larger distance.
  void catch_up(std::uint64_t tick);

  /// Forgets everything in flight.
  void clear() noexcept { sent_until_ = 0; }

  /// @return the modes that joints wait for; joints whose drive is in its mode start.
  [[nodiscard]] Frames modes(const BenchCycle& now);

  /// @return the set-points that are due, up to the end of the window.
  [[nodiscard]] Frames points(const BenchCycle& now);

 private:
  SetPointLead lead_;
  JointPlans& plans_;
  std::uint64_t sent_until_ = 0;
};

}  // namespace vdrive::ros2
