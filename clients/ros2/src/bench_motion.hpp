// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_link.hpp"
#include "bench_power.hpp"
#include "joint_path.hpp"
#include "joint_tracker.hpp"
#include "requests.hpp"
#include "set_point_lead.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// What the bridge commands a joint to do.
enum class Duty : std::uint8_t {
  none,        ///< nothing was commanded since it was enabled
  hold,        ///< stays where the last command ended
  track,       ///< follows positions that come from time to time
  trajectory,  ///< follows a trajectory
  velocity,
  effort,
  settle,  ///< comes to rest, then follows positions
};

/// @return such as "trajectory".
[[nodiscard]] std::string_view to_string(Duty duty) noexcept;

/// A trajectory that ended early.
struct BrokenTrajectory {
  std::uint64_t number = 0;
  std::string reason;
};

/// Moves the joints of one bench: what each of them does in the ticks to come. The set-points of a
/// tick go to the bench some time before it, and what was sent stays: a new command begins after
/// it. For one thread.
class BenchMotion {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param link outlives this
  BenchMotion(client::Session& session, BenchLink& link, bridge::Reports& reports,
              double command_timeout);

  [[nodiscard]] BenchLink& link() noexcept { return link_; }

  [[nodiscard]] const BenchLink& link() const noexcept { return link_; }

  // ---- power

  /// Takes control and enables all axes, or disables those that it has enabled.
  /// @param resets_faults also of axes in a fault, once
  void want_enabled(bool wanted, bool resets_faults) { power_.want_enabled(wanted, resets_faults); }

  [[nodiscard]] bool wants_enabled() const noexcept { return power_.wants_enabled(); }

  /// @return whether no axis that this session holds is enabled.
  [[nodiscard]] bool is_disabled() const;

  /// @return why the joint cannot be commanded now; empty when it can.
  [[nodiscard]] std::string obstacle(std::size_t place) const;

  /// @return the same for a trajectory.
  [[nodiscard]] std::string trajectory_obstacle(std::size_t place) const;

  // ---- commands

  /// Carries out a command, or reports why not.
  void command(const JointCommand& command);

  /// Brakes the joints that velocity or effort move.
  void stop_free_joints(const std::string& reason);

  /// @param wanted a later tick, taken when it is near and no set-points are on their way
  /// @return the last tick that set-points were sent for: a new path begins there. Only with a
  ///         state.
  [[nodiscard]] std::uint64_t begin_tick(std::uint64_t wanted = 0);

  /// @return how the joint moves in the begin_tick().
  [[nodiscard]] JointMotion motion(std::size_t place) const;

  /// Starts a path at `begin`, which is the begin_tick().
  /// @param number of the trajectory
  void follow(std::size_t place, std::shared_ptr<const JointPath> path, std::uint64_t begin,
              std::uint64_t number);

  /// Brakes the joints that follow this trajectory.
  void brake(std::uint64_t number);

  /// @return the number of the trajectory that the joint follows, 0 = none.
  [[nodiscard]] std::uint64_t trajectory_of(std::size_t place) const {
    return plans_[place].duty == Duty::trajectory ? plans_[place].trajectory : 0;
  }

  /// @return whether a joint follows this trajectory.
  [[nodiscard]] bool follows(std::uint64_t number) const;

  // ---- each turn

  /// Takes the state of the bench and sends what is due. @return the trajectories that ended before
  /// time.
  std::vector<BrokenTrajectory> update(Clock::time_point now);

  [[nodiscard]] std::vector<Duty> duties() const;

  /// @return the state that the last update() took; none while the bench sends no status.
  [[nodiscard]] const std::shared_ptr<const BenchState>& state() const noexcept { return state_; }

  /// @return whether set-points have to be sent again soon.
  [[nodiscard]] bool is_busy() const;

 private:
  struct Plan {
    Duty duty = Duty::none;
    double position = 0.0;  ///< hold [rad or m]
    double value = 0.0;     ///< velocity and effort [SI]; settle: the position to go to
    std::optional<JointTracker> tracker{};
    std::shared_ptr<const JointPath> path{};
    std::uint64_t begin = 0;         ///< tick of the path's time 0
    std::uint64_t trajectory = 0;    ///< number
    std::uint64_t commanded_at = 0;  ///< tick of the last command
    std::uint64_t sent_for = 0;      ///< tick of the velocity or effort that was sent last
    std::uint64_t ends_at = 0;       ///< hold: tick of the last set-point, until the drive shows it
    int repeats = 0;                 ///< of the end of this motion
    double interval = 0.0;           ///< [s] between commands, as they come
    bool is_due = false;             ///< velocity and effort: to be sent
    bool is_lost = false;            ///< no command came in time, and that was reported
  };

  void drop_plans(const std::string& reason, std::vector<BrokenTrajectory>& broken);
  void check_enabled(std::vector<BrokenTrajectory>& broken);
  void check_timeouts();
  void catch_up(std::vector<BrokenTrajectory>& broken);
  void repeat_refused_ends();
  void send_positions();
  void send_free();
  void settle();
  void start_tracking(std::size_t place, double goal);
  [[nodiscard]] bool moves_by_itself(std::size_t place) const;
  void add_point(std::size_t place, std::uint64_t tick, client::SetPointFrame& frame);
  bool send(const std::vector<client::SetPointFrame>& frames);
  void track(std::size_t place, const JointCommand& command);
  void set_free(std::size_t place, Duty duty, double value);
  [[nodiscard]] std::string check_value(std::size_t place, const JointCommand& command) const;
  [[nodiscard]] JointMotion demand(std::size_t place) const;
  [[nodiscard]] bool positions_are_due() const;
  [[nodiscard]] bool is_on_trajectory() const;

  [[nodiscard]] std::uint16_t axis_number(std::size_t place) const {
    return link_.joints()[place].axis.axis;
  }

  [[nodiscard]] std::int32_t user_units(std::size_t place, double value) const;

  [[nodiscard]] std::string name_of(std::size_t place) const {
    return "joint " + link_.joints()[place].name;
  }

  client::Session& session_;
  BenchLink& link_;
  bridge::Reports& reports_;
  const double command_timeout_;
  BenchPower power_;
  SetPointLead lead_;
  std::vector<Plan> plans_;
  std::shared_ptr<const BenchState> state_;
  std::shared_ptr<const std::vector<JointLimits>> limits_;
  std::uint64_t sent_until_ = 0;  ///< tick
};

}  // namespace vdrive::ros2
