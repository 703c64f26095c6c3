// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "joint_plan.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/clock_mode.hpp"

#include <cstdint>
#include <vector>

namespace vdrive::ros2 {

/// How far ahead of a bench its set-points are sent, in ticks. In lock-step, where the length of
/// the next step is not known, it does not depend on wall time.
class SetPointLead {
 public:
  /// @param period [s] of a tick
  SetPointLead(ClockMode clock, double period) : clock_(clock), period_(period) {}

  /// @param rate drive time over wall time
  void set_rate(double rate) noexcept { rate_ = rate; }

  /// @return ticks from the newest state to the first one that a new set-point can reach.
  [[nodiscard]] std::uint64_t lead() const;

  /// @return ticks that have set-points while a motion lasts: those of a trajectory outlast a pause
  ///         of the machine, positions that come from time to time are late by no more than needed.
  [[nodiscard]] std::uint64_t window(bool is_trajectory) const;

  /// @return ticks before the begin of a trajectory, from which on it is taken.
  [[nodiscard]] std::uint64_t ahead_of_trajectory() const;

  /// Set-points came too late: the machine, or the way to the bench, is slower than the lead.
  void lengthen() noexcept;

 private:
  [[nodiscard]] std::uint64_t ticks(double seconds) const;

  ClockMode clock_;
  double period_;
  double rate_ = 1.0;
  double lead_ = kShortest;  ///< [s of wall time]

  /// [s] Some turns of the controller: one that is late does not miss its tick.
  static constexpr double kShortest = 0.008;
};

/// The set-points of a bench: the frames that its plans need, for the ticks that can still be
/// reached. What was sent stays in force: a new motion begins after it.
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

  /// Chooses sent_until() for a motion that begins after it. Only for a stream that was not
  /// running: a running one continues where it is.
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

  /// @return the modes that joints wait for; joints whose drive is in that mode begin.
  [[nodiscard]] Frames modes(const BenchNow& now);

  /// @return the set-points that are due, up to the end of the window.
  [[nodiscard]] Frames points(const BenchNow& now);

 private:
  SetPointLead lead_;
  JointPlans& plans_;
  std::uint64_t sent_until_ = 0;
};

}  // namespace vdrive::ros2
