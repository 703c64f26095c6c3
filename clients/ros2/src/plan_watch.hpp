// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "joint_plan.hpp"
#include "reports.hpp"
#include "set_point_stream.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// A trajectory that ended early.
struct BrokenTrajectory {
  std::uint64_t number = 0;
  std::string reason;
};

using BrokenTrajectories = std::vector<BrokenTrajectory>;

/// Changes the plans of a bench when something goes wrong, and reports it: the bench was lost, no
/// command came in time, set-points came too late.
class PlanWatch {
 public:
  /// @param plans outlives this, as the others do
  /// @param command_timeout [s] after which a joint brakes; 0 = never
  PlanWatch(JointPlans& plans, SetPointStream& stream, bridge::Reports& reports,
            double command_timeout)
      : plans_(plans), stream_(stream), reports_(reports), command_timeout_(command_timeout) {}

  /// The bench has dropped the waiting set-points, or holds where they end: all plans end.
  /// @return the trajectories that end with it.
  BrokenTrajectories drop(const std::string& reason);

  /// Does what is due in this turn. @return the trajectories that ended early.
  BrokenTrajectories check(const BenchNow& now);

 private:
  void check_commands(const BenchNow& now);
  [[nodiscard]] BrokenTrajectories catch_up(const BenchNow& now);
  void check_ends(const BenchNow& now);
  void warn(const BenchNow& now, std::size_t place, const std::string& text);

  JointPlans& plans_;
  SetPointStream& stream_;
  bridge::Reports& reports_;
  const double command_timeout_;
};

}  // namespace vdrive::ros2
