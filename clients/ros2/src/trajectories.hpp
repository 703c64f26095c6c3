// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "requests.hpp"
#include "ros_time.hpp"
#include "served_benches.hpp"
#include "vdrive/wire/ros.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

namespace vdrive::ros2 {

struct TrajectoryStart;

/// Accepts, starts and ends trajectories. At most one waits, for its time or for the limits of its
/// joints; any number can be in progress. For one thread.
class Trajectories {
 public:
  /// @param benches must outlive this, like `reports`
  Trajectories(ServedBenches& benches, const Settings& settings, bridge::Reports& reports)
      : benches_(benches),
        reports_(reports),
        start_tolerance_(settings.start_tolerance),
        stamps_(settings.stamp_ahead) {}

  /// Accepts a message, or reports why it is refused. It replaces a trajectory that has not
  /// started.
  void take(const ros::JointTrajectory& message, const wire::WriterId& writer);

  /// Records that the axes were enabled or disabled: the next stamp of each writer counts as its
  /// first, and a trajectory that waits is dropped on disabling.
  void note_enable(bool is_enabled);

  /// Starts trajectories that are due.
  void start_due();

  /// Brakes the joints of trajectories that ended early, and reports why.
  void break_off(const BrokenTrajectories& broken);

  /// Breaks off the trajectory of a bench whose run has ended.
  void end_with(BenchMotion& motion);

  /// Reports and forgets trajectories whose set-points have all been sent.
  void forget_ended();

 private:
  /// A trajectory that waits for its time, or for the limits.
  struct Waiting {
    Trajectory trajectory;
    std::map<std::uint32_t, std::uint64_t> limits;  ///< required Seen::limits_read, by bench
    bool is_checked = false;
  };

  void refuse(const std::string& problem);
  [[nodiscard]] std::string problem_of(const Trajectory& trajectory,
                                       const wire::WriterId& writer) const;
  [[nodiscard]] std::string obstacle_to(const Trajectory& trajectory) const;
  [[nodiscard]] bool try_start(Waiting& waiting);
  [[nodiscard]] bool has_limits(const Waiting& waiting) const;
  void begin(const Trajectory& trajectory, const TrajectoryStart& start);
  void brake_all(std::uint64_t number);

  ServedBenches& benches_;
  bridge::Reports& reports_;
  const double start_tolerance_;
  StampOrder stamps_;
  std::optional<Waiting> waiting_;
  std::map<std::uint64_t, std::string> running_;  ///< number and description
  std::uint64_t last_number_ = 0;
};

/// Compares a stamp with the time of each bench: in lock-step each has its own.
/// @return the error in the stamp; empty if it is valid.
[[nodiscard]] std::string stamp_problem(const StampOrder& order, const wire::WriterId& writer,
                                        std::int64_t stamp, const ServedBenches& benches,
                                        const std::set<std::uint32_t>& numbers);

}  // namespace vdrive::ros2
