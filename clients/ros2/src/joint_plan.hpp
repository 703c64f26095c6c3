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

/// What the bridge commands a joint to do.
enum class Duty : std::uint8_t {
  none,        ///< nothing was commanded since it was enabled
  hold,        ///< stays where the last command ended
  track,       ///< follows positions that come from time to time
  trajectory,  ///< follows a trajectory
  velocity,    ///< follows velocities that come from time to time, and keeps the last one
  effort,      ///< the same with efforts
  settle,      ///< comes to rest, then follows positions
};

/// @return such as "trajectory".
[[nodiscard]] std::string_view to_string(Duty duty) noexcept;

/// What one joint does in the ticks to come: commands change it, each tick takes a set-point from
/// it. Whether a command is permitted is for its caller. For one thread.
class JointPlan {
 public:
  /// What the drive shows after the last set-point of a motion.
  enum class End : std::uint8_t {
    open,      ///< there is none, its tick has not come, or the drive holds its effect back
    reached,   ///< it is where that set-point leads
    refused,   ///< it is not: the set-point is sent again
    given_up,  ///< the set-point was sent too often
  };

  [[nodiscard]] Duty duty() const noexcept { return duty_; }

  /// @return whether each tick needs a set-point.
  [[nodiscard]] bool streams() const noexcept {
    return duty_ == Duty::track || duty_ == Duty::trajectory || line_.has_value();
  }

  /// @return whether it waits for the drive to be in the mode of its duty.
  [[nodiscard]] bool is_entering() const noexcept {
    return duty_ == Duty::settle || (is_free() && !is_entered_);
  }

  /// @return whether velocity or effort move it.
  [[nodiscard]] bool runs_freely() const noexcept {
    return duty_ == Duty::effort || (duty_ == Duty::velocity && value_ != 0.0);
  }

  /// @return the number of the trajectory that the joint follows, 0 = none.
  [[nodiscard]] std::uint64_t trajectory() const noexcept {
    return duty_ == Duty::trajectory ? trajectory_ : 0;
  }

  /// @return whether the drive moves, or may move, by another cause than a stream of positions.
  [[nodiscard]] bool moves_by_itself(const JointNow& now) const noexcept;

  /// @return how the joint moves in `tick`, up to which positions were sent.
  [[nodiscard]] JointMotion motion(const JointNow& now, std::uint64_t tick) const;

  // ---- commands

  /// Goes to a position; a joint that moves by itself comes to rest first.
  /// @return whether its positions begin with this command
  [[nodiscard]] bool go_to(const JointNow& now, double position);

  /// Runs with a velocity or an effort; a drive in another mode comes to rest and changes it first.
  /// @return whether its set-points begin with this command
  bool run(const JointNow& now, Duty duty, double value);

  /// @param begin tick of the path's time 0
  void follow(const JointNow& now, std::shared_ptr<const JointPath> path, std::uint64_t begin,
              std::uint64_t number);

  /// Leaves its trajectory and brakes.
  /// @param tick up to which positions were sent
  void brake(const JointNow& now, std::uint64_t tick);

  /// Brakes if velocity or effort move it: from a velocity by the ramp, from an effort as the drive
  /// does when its mode changes. @return whether they do.
  bool brake_free();

  // ---- each turn

  /// Brakes a joint that was not commanded for `timeout` [s]. @return whether it has moved.
  bool brake_without_command(const JointNow& now, double timeout);

  /// The bench has passed the last set-point: the drive holds, and what follows starts there.
  /// @return the number of the trajectory that ends with it, 0 = none
  std::uint64_t start_again(const JointNow& now);

  /// Compares the drive with the end of a motion. @return each result but `open` once.
  [[nodiscard]] End check_end(const JointNow& now);

  /// Goes to the end of the motion once more.
  void repeat_end(const JointNow& now);

  /// @return whether a joint that waited for its mode begins with its set-points now.
  [[nodiscard]] bool settles(const JointNow& now);

  // ---- set-points

  /// @return the position, velocity or effort for `tick`: the tick after the one of the call
  ///         before.
  [[nodiscard]] client::SetPoint next_point(const JointNow& now, std::uint64_t tick);

  /// @param tick in which the drive shows it
  /// @return the mode that the joint waits for, where it was not sent or the drive did not take it.
  [[nodiscard]] std::optional<client::SetPoint> mode_point(const JointNow& now, std::uint64_t tick);

 private:
  [[nodiscard]] bool is_free() const noexcept {
    return duty_ == Duty::velocity || duty_ == Duty::effort;
  }

  [[nodiscard]] OperatingMode mode() const noexcept;
  [[nodiscard]] double value_of_drive(const JointNow& now) const noexcept;
  [[nodiscard]] bool is_at_end(const JointNow& now) const noexcept;
  [[nodiscard]] JointTracker& tracker();
  [[nodiscard]] ValueLine& line();
  double note_command(const JointNow& now);
  double time_of_line(const JointNow& now, double passed, bool begins);
  void enter(Duty duty);
  bool lead_to_value(double last, double over);
  void lead_from_drive(const JointNow& now);
  void track(const JointMotion& start, double goal);
  bool put_position(const JointNow& now, std::uint64_t tick, client::SetPoint& point);
  bool put_value(const JointNow& now, client::SetPoint& point);

  Duty duty_ = Duty::none;
  double position_ = 0.0;  ///< hold [rad or m]
  double value_ = 0.0;     ///< velocity and effort [SI]; settle: the position to go to
  std::optional<JointTracker> tracker_;
  std::optional<ValueLine> line_;  ///< velocity and effort, on the way to `value_`
  std::shared_ptr<const JointPath> path_;
  std::uint64_t begin_ = 0;         ///< tick of the path's time 0
  std::uint64_t trajectory_ = 0;    ///< number
  std::uint64_t commanded_at_ = 0;  ///< tick of the last command
  std::uint64_t sent_for_ = 0;      ///< entering: tick of the mode that was sent last, 0 = none
  std::uint64_t enters_at_ = 0;     ///< entering: tick before which the mode may be an older one
  std::uint64_t ends_at_ = 0;       ///< tick of the last set-point, until the drive shows it
  int repeats_ = 0;                 ///< of the end of this motion
  double interval_ = 0.0;           ///< [s] between commands, as they come
  bool is_entered_ = false;         ///< velocity and effort: the drive has their mode
  bool is_lost_ = false;            ///< no command came in time, and it was braked
};

/// The plans of a bench, in the order of its joints.
using JointPlans = std::vector<JointPlan>;

}  // namespace vdrive::ros2
