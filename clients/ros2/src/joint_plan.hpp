// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "joint_path.hpp"
#include "joint_tracker.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace vdrive::ros2 {

/// The kind of motion that the bridge commands for a joint.
enum class JointTask : std::uint8_t {
  none,        ///< no command since it was enabled
  hold,        ///< stay where the last command ended
  track,       ///< follow positions that arrive from time to time
  trajectory,  ///< follow a trajectory
  velocity,    ///< follow velocities that arrive from time to time, and keep the last one
  effort,      ///< as velocity, with efforts
  settle,      ///< come to rest, then follow positions
};

/// @return such as "trajectory".
[[nodiscard]] std::string_view to_string(JointTask task) noexcept;

/// The plan of one joint for the coming ticks: commands change it, and each tick takes a set-point
/// from it. The caller checks whether a command is permitted. For one thread.
class JointPlan {
 public:
  /// The reaction of the drive to the last set-point of a motion.
  enum class End : std::uint8_t {
    open,      ///< no such set-point, its tick has not come, or the drive is held back
    reached,   ///< the drive has arrived
    refused,   ///< the drive has not: the set-point is sent again
    given_up,  ///< the set-point was sent too often
  };

  [[nodiscard]] JointTask task() const noexcept { return task_; }

  /// @return whether every tick needs a set-point.
  [[nodiscard]] bool streams() const noexcept {
    return task_ == JointTask::track || task_ == JointTask::trajectory || line_.has_value();
  }

  /// @return whether it waits for the drive to enter the mode of its task.
  [[nodiscard]] bool is_entering() const noexcept {
    return task_ == JointTask::settle || (is_free() && !is_entered_);
  }

  /// @return whether it is moved by velocity or effort.
  [[nodiscard]] bool runs_freely() const noexcept {
    return task_ == JointTask::effort || (task_ == JointTask::velocity && value_ != 0.0);
  }

  /// @return the number of the trajectory that the joint follows, 0 = none.
  [[nodiscard]] std::uint64_t trajectory() const noexcept {
    return task_ == JointTask::trajectory ? trajectory_ : 0;
  }

  /// @return whether the drive moves, or may move, for a reason other than a stream of positions.
  [[nodiscard]] bool moves_by_itself(const JointCycle& now) const noexcept;

  /// @return the motion of the joint in `tick`, the last one for which positions were sent.
  [[nodiscard]] JointMotion motion(const JointCycle& now, std::uint64_t tick) const;

  // ---- commands

  /// Goes to a position; a joint that moves by itself comes to rest first.
  /// @return whether its positions start with this command
  [[nodiscard]] bool go_to(const JointCycle& now, double position);

  /// Runs with a velocity or an effort; a drive in another mode comes to rest and changes its mode
  /// first.
  /// @return whether its set-points start with this command
  bool run(const JointCycle& now, JointTask task, double value);

  /// @param begin tick of the path's time 0
  void follow(const JointCycle& now, std::shared_ptr<const JointPath> path, std::uint64_t begin,
              std::uint64_t number);

  /// Leaves its trajectory and brakes.
  /// @param tick the last one for which positions were sent
  void brake(const JointCycle& now, std::uint64_t tick);

  /// Brakes a joint moved by velocity or effort: from a velocity along the ramp, from an effort as
  /// the drive does when its mode changes.
  /// @return whether it was moved by velocity or effort.
  bool brake_free();

  // ---- each cycle

  /// Brakes a joint that got no command for `timeout` [s].
  /// @return whether it was moving.
  bool brake_without_command(const JointCycle& now, double timeout);

  /// Restarts after the bench has run past the last set-point: the drive holds, and new motion
  /// starts there.
  /// @return the number of the trajectory that ends with this, 0 = none
  std::uint64_t start_again(const JointCycle& now);

  /// Compares the drive with the end of a motion.
  /// @return each result except `open` only once.
  [[nodiscard]] End check_end(const JointCycle& now);

  /// Commands the end of the motion again.
  void repeat_end(const JointCycle& now);

  /// @return whether a joint that waited for its mode starts with its set-points now.
  [[nodiscard]] bool settles(const JointCycle& now);

  // ---- set-points

  /// @return the position, velocity or effort for `tick`, which must follow the tick of the
  ///         previous call.
  [[nodiscard]] client::SetPoint next_point(const JointCycle& now, std::uint64_t tick);

  /// @param tick in which the drive will show the mode
  /// @return the set-point with the mode that the joint waits for; nothing if that was sent and may
  ///         still take effect.
  [[nodiscard]] std::optional<client::SetPoint> mode_point(const JointCycle& now,
                                                           std::uint64_t tick);

 private:
  [[nodiscard]] bool is_free() const noexcept {
    return task_ == JointTask::velocity || task_ == JointTask::effort;
  }

  [[nodiscard]] OperatingMode mode() const noexcept;
  [[nodiscard]] double value_of_drive(const JointCycle& now) const noexcept;
  [[nodiscard]] bool is_at_end(const JointCycle& now) const noexcept;
  [[nodiscard]] JointTracker& tracker();
  [[nodiscard]] ValueLine& line();
  double note_command(const JointCycle& now);
  double time_of_line(const JointCycle& now, double passed, bool begins);
  void enter(JointTask task);
  bool lead_to_value(double last, double over);
  void lead_from_drive(const JointCycle& now);
  void track(const JointMotion& start, double goal);
  bool put_position(const JointCycle& now, std::uint64_t tick, client::SetPoint& point);
  bool put_value(const JointCycle& now, client::SetPoint& point);

  JointTask task_ = JointTask::none;
  double position_ = 0.0;  ///< task hold [rad or m]
  double value_ = 0.0;     ///< velocity and effort [SI]; settle: the position to go to
  std::optional<JointTracker> tracker_;
  std::optional<ValueLine> line_;  ///< velocity and effort, on the way to `value_`
  std::shared_ptr<const JointPath> path_;
  std::uint64_t begin_ = 0;         ///< tick of the path's time 0
  std::uint64_t trajectory_ = 0;    ///< number
  std::uint64_t commanded_at_ = 0;  ///< tick of the last command
  std::uint64_t sent_for_ = 0;      ///< entering: tick of the last mode sent, 0 = none
  std::uint64_t enters_at_ = 0;     ///< entering: before this tick, an earlier mode may still act
  std::uint64_t ends_at_ = 0;       ///< tick of the last set-point, until the drive shows it
  int repeats_ = 0;                 ///< repetitions of the end of this motion
  double interval_ = 0.0;           ///< [s] measured interval between commands
  bool is_entered_ = false;         ///< velocity and effort: the drive is in their mode
  bool is_lost_ = false;            ///< no command arrived in time, and the joint was braked
};

/// The plans of a bench, in the order of its joints.
using JointPlans = std::vector<JointPlan>;

}  // namespace vdrive::ros2
