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

/// Takes, starts and ends trajectories. One waits for its time or for the limits of its joints;
/// any number are under way. For one thread.
class Trajectories {
 public:
  /// @param benches outlives this, as `reports` does
  Trajectories(ServedBenches& benches, const Settings& settings, bridge::Reports& reports)
      : benches_(benches),
        reports_(reports),
        start_tolerance_(settings.start_tolerance),
        stamps_(settings.stamp_ahead) {}

  /// Takes a message, or reports why it is refused. It replaces one that has not started.
  void take(const ros::JointTrajectory& message, const wire::WriterId& writer);

  /// The axes were enabled or disabled: each writer begins with a new stamp, and nothing that waits
  /// starts without power.
  void note_enable(bool is_enabled);

  /// Starts what is due.
  void start_due();

  /// Brakes the joints of trajectories that ended early, and reports why.
  void break_off(const BrokenTrajectories& broken);

  /// Breaks off the trajectory of a bench whose run has ended.
  void end_with(BenchMotion& motion);

  /// Reports those whose set-points were all sent.
  void forget_ended();

 private:
  /// A trajectory that waits for its time, or for the limits.
  struct Waiting {
    Trajectory trajectory;
    std::map<std::uint32_t, std::uint64_t> limits;  ///< what limits_read() has to reach, by bench
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
  std::map<std::uint64_t, std::string> running_;  ///< number and text
  std::uint64_t last_number_ = 0;
};

/// Compares a stamp with the time of each bench: in lock-step each has its own.
/// @return why the stamp is not good; empty when it is.
[[nodiscard]] std::string stamp_problem(const StampOrder& order, const wire::WriterId& writer,
                                        std::int64_t stamp, const ServedBenches& benches,
                                        const std::set<std::uint32_t>& numbers);

}  // namespace vdrive::ros2
