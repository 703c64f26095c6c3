// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "bench_power.hpp"
#include "joint_plan.hpp"
#include "reports.hpp"
#include "requests.hpp"
#include "set_point_stream.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// A trajectory that ended early.
struct BrokenTrajectory {
  std::uint64_t number = 0;
  std::string reason;
};

using BrokenTrajectories = std::vector<BrokenTrajectory>;

/// Moves the joints of one bench: takes commands and trajectories for them, and in each cycle
/// handles, in this order, the state of the bench, its power, the plans of its joints and their
/// set-points. Ends or changes plans if the bench was lost, no command arrived in time, or
/// set-points were too late. For one thread.
class BenchMotion {
 public:
  using Clock = std::chrono::steady_clock;

  /// Sends set-points to the bench.
  /// @return the outcome.
  using Send = std::function<client::Outcome(const SetPointStream::Frames& frames)>;

  /// @param session that commands the axes
  /// @param bench must outlive this, like `reports`
  /// @param command_timeout [s] after which a joint without a command brakes; 0 = never
  BenchMotion(std::uint64_t session, Bench& bench, bridge::Reports& reports, double command_timeout,
              Send send);
  ~BenchMotion() = default;
  BenchMotion(const BenchMotion&) = delete;  // its parts refer to its plans
  BenchMotion& operator=(const BenchMotion&) = delete;

  [[nodiscard]] Bench& bench() noexcept { return bench_; }

  [[nodiscard]] BenchPower& power() noexcept { return power_; }

  /// @return whether no axis held by this session is enabled.
  [[nodiscard]] bool is_disabled() const;

  /// @return why no trajectory can start with the joint now; empty if one can.
  [[nodiscard]] std::string trajectory_obstacle(std::size_t place) const;

  // ---- commands

  /// Carries out a command, or reports why it cannot.
  void command(const JointCommand& command);

  /// Brakes the joints that are moved by velocity or effort.
  void stop_free_joints(const std::string& reason);

  /// @param wanted a later tick, used if it is near and no set-points are in flight
  /// @return the last tick for which set-points were sent: a new path starts there. Requires a
  ///         state.
  [[nodiscard]] std::uint64_t begin_tick(std::uint64_t wanted = 0);

  /// @return the motion of the joint in begin_tick(). Requires that there is no obstacle.
  [[nodiscard]] JointMotion motion(std::size_t place) const;

  /// Starts a path at `begin`, which must be begin_tick().
  /// @param number of the trajectory
  void follow(std::size_t place, std::shared_ptr<const JointPath> path, std::uint64_t begin,
              std::uint64_t number);

  /// Brakes the joints that follow this trajectory.
  void brake(std::uint64_t number);

  /// @return the task of each joint, in the order of the joints.
  [[nodiscard]] std::vector<JointTask> tasks() const;

  /// @return the number of the trajectory that the joint follows, 0 = none.
  [[nodiscard]] std::uint64_t trajectory_of(std::size_t place) const {
    return plans_[place].trajectory();
  }

  /// @return whether a joint follows this trajectory.
  [[nodiscard]] bool follows(std::uint64_t number) const;

  // ---- each cycle

  /// Takes the newest state of the bench and sends what is due.
  /// @return the trajectories that ended early.
  BrokenTrajectories update(Clock::time_point now);

  /// @return the state used by the last update(); null while the bench sends no status.
  [[nodiscard]] const Bench::State& state() const noexcept { return now_.seen.state; }

  /// @return whether further set-points must be sent soon.
  [[nodiscard]] bool is_busy() const { return stream_.is_running(); }

 private:
  [[nodiscard]] std::string obstacle(std::size_t place) const;
  [[nodiscard]] std::string first_obstacle() const;
  BrokenTrajectories end_all(const std::string& reason);
  void check_commands();
  [[nodiscard]] BrokenTrajectories catch_up();
  void check_ends();
  void warn(std::size_t place, const std::string& text);
  [[nodiscard]] std::vector<std::size_t> free_joints() const;
  void brake_joints(const std::vector<std::size_t>& joints, const std::string& reason);
  void send(const SetPointStream::Frames& frames);

  const std::uint64_t session_;
  Bench& bench_;
  bridge::Reports& reports_;
  const double command_timeout_;
  const Send send_;
  BenchPower power_;
  JointPlans plans_;
  SetPointStream stream_;
  BenchCycle now_;
};

/// @return what prevents `session` from commanding the axis, as words that follow the name of the
///         joint; empty if nothing does.
/// @param has_limits whether the limits of the joint were read
/// @param names of other sessions, or nullptr
[[nodiscard]] std::string obstacle_of(const client::AxisSnapshot& axis, std::uint64_t session,
                                      bool has_limits, const Bench::Names* names);

/// @return which limit the value of a command violates, in the same form.
[[nodiscard]] std::string problem_of(const JointCommand& command, const ServedJoint& joint,
                                     const JointLimits& limits);

}  // namespace vdrive::ros2
