// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <Eigen/Core>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// What a group does, in the words of PLCopen part 4.
enum class GroupState : std::uint8_t {
  disabled,    ///< some axis is not in Operation enabled
  standby,     ///< enabled and at rest
  moving,      ///< enabled and on the way
  stopping,    ///< a quick stop is in progress
  error_stop,  ///< some axis has a fault
};

/// @return such as "error_stop".
[[nodiscard]] std::string_view to_string(GroupState state) noexcept;

/// All axes of a group after one tick. Vectors and axes are in the order of the group.
struct GroupStatus {
  std::uint64_t tick = 0;  ///< of the first axis' bench
  GroupState state = GroupState::disabled;
  std::size_t queued = 0;  ///< moves that have not started yet
  std::vector<AxisSnapshot> axes;

  /// 6062h of each axis [UU].
  [[nodiscard]] Eigen::VectorXd demand() const;

  /// 6064h of each axis [UU].
  [[nodiscard]] Eigen::VectorXd actual() const;

  /// In cyclic streaming: the axes that do not follow the streamed set-point (bit 12 = 0).
  [[nodiscard]] std::vector<AxisId> not_following() const;
};

/// The state of a group in one tick while a call waits.
struct GroupProgress {
  std::uint64_t tick = 0;  ///< of the first axis' bench
  double fraction = 0.0;   ///< of the present move that is done, 0 to 1; 0 without a move
  std::span<const AxisSnapshot> axes;
};

/// How long a call may take, what it waits for, and who observes it.
struct GroupCallOptions {
  /// Drive time. By default 60 s; for a move its duration and 5 s more.
  std::optional<std::chrono::nanoseconds> timeout{};
  Until until = Until::done;
  /// Called at every tick that the call observes, in its thread. It must not call the group.
  std::function<void(const GroupProgress&)> progress{};
  bool keep_target = false;  ///< of enable_all() only: see CallOptions
};

/// How a group moves: each axis within its own 6081h, 6083h and 6084h, bounded by 607Fh, 6080h,
/// 60C5h and 60C6h, times these factors (PLCopen: MC_GroupSetOverride), 0 < factor <= 1.
struct GroupMoveOptions {
  double velocity_factor = 1.0;
  double acceleration_factor = 1.0;
  double deceleration_factor = 1.0;
  GroupCallOptions call{};
};

/// What a group streams, each in its cyclic synchronous mode.
enum class Streamed : std::uint8_t {
  positions,   ///< 607Ah [UU], 6060h = 8
  velocities,  ///< 60FFh [UU/s], 6060h = 9
  torques,     ///< 6071h [‰ of rated torque], 6060h = 10
};

/// How a group streams set-points.
struct StreamOptions {
  /// In real time each set-point goes this far ahead of its tick.
  std::chrono::nanoseconds lead = std::chrono::milliseconds(10);
  Pace pace = Pace::drive;  ///< lock-step: whether each set-point steps one tick
  Streamed what = Streamed::positions;
};

/// Axes that move together, on one bench or on several that share a clock. A handle: copies refer
/// to the same group. Calls after the end of its session fail.
///
/// Each command is one frame a bench for all its axes, so that they act on it in one tick. Several
/// benches act in the same tick too: in lock-step the group steps them together; in real time, with
/// equal period, rate 1 and synchronised clocks, commands that must act together carry the tick
/// number in which they are in force.
///
/// Messages name the axis that refused, failed or was late. While a call waits for motion it checks
/// every axis. When one has a fault, loses Operation enabled, its service stops sending, another
/// session takes it, or this session gives it another command, the group sends the others a quick
/// stop (605Ah) at once. The call returns `failed`, `lost`, or `refused` with the session that has
/// taken the axis, when they are at rest; an axis that was taken is left to that session, and one
/// with another command to that command. poll() does the same while no call waits, and so does
/// monitor(), which does not look for other commands. A call that times out leaves the motion as it
/// is.
///
/// One call at a time, save that halt_all() and quick_stop_all() may come from another thread in
/// real time.
class AxisGroup {
 public:
  /// @param axes addresses or names, each once; at most kMostAxesAtOnce of one
  ///        bench
  /// @return not_found, refused when an axis appears twice or the benches do not share a clock.
  static Result<AxisGroup> create(Session& session, std::span<const std::string> axes);

  /// The same of axes that this session found.
  static Result<AxisGroup> create(Session& session, std::span<const Axis> axes);

  /// The axes in the order of the group.
  [[nodiscard]] std::vector<AxisId> axes() const;

  /// The present state of all axes.
  Result<GroupStatus> status() const;

  /// Takes control of every axis, also from other sessions, which lose it. The axes continue as
  /// they are.
  Outcome take_over();

  /// Brings every axis to Operation enabled (MC_GroupEnable), as long as that takes its drive. No
  /// axis moves: see Axis::enable().
  /// @return refused, with nothing done, when an axis has a fault.
  Outcome enable_all(const GroupCallOptions& options = {});

  /// Shutdown (0006h) of every axis without a fault (MC_GroupDisable). Drops the queue.
  Outcome disable_all(const GroupCallOptions& options = {});

  /// A straight line in axis space to absolute positions [UU, rounded to whole ones]
  /// (MC_MoveLinearAbsolute): all axes start on one tick, keep the proportions of their ways and
  /// arrive on one tick, the slowest at its limit. Starts from rest, or while the axes move along a
  /// line of this group to a target that lies on that line too: further on, a stop before its end,
  /// or back. Drops the queue.
  ///
  /// From rest the times are chosen for ways that are half a unit longer: an axis at rest may stand
  /// up to half a unit beside the position that 6062h shows. In motion the axes stay on their line
  /// and arrive together up to the rounding to whole units.
  /// @return refused, with nothing changed, when an axis cannot take part: not enabled, beyond its
  ///         software limits, a move of more than 4294 s, or in motion and not on one line with the
  ///         target: the message has what is beside the line, and what the line has there. Where
  ///         an axis ignores its set-point the others are stopped before the tick in lock-step,
  ///         and halted in real time or where they moved.
  Outcome move_together(const Eigen::VectorXd& targets, const GroupMoveOptions& options = {});

  /// The same by displacements from the demand positions (MC_MoveLinearRelative).
  Outcome move_by(const Eigen::VectorXd& displacements, const GroupMoveOptions& options = {});

  /// Appends a move_together (buffer mode mcBuffered). It starts in wait_all() or poll(), as soon
  /// as the demands of the one before have arrived, without waiting for the position windows: in
  /// lock-step without a tick between. `options.call` is not used.
  Outcome queue_move(const Eigen::VectorXd& targets, const GroupMoveOptions& options = {});

  /// Waits until the present move and the queue have ended. The default time-out counts for each
  /// move. A halt keeps the queue; a fault, a refusal, a quick stop and a disable drop it.
  Outcome wait_all(const GroupCallOptions& options = {});

  /// Checks the group once, without stepping: stops the others when an axis failed, starts the next
  /// move of the queue when the last has arrived. For a program with its own loop.
  Result<GroupStatus> poll();

  /// Real time: checks for faults in a thread of its own while no call waits.
  /// @return refused in lock-step, where time stands still between calls: use poll().
  Outcome monitor(bool on);

  /// Brakes the enabled axes to standstill by 605Dh (010Fh; MC_GroupHalt, MC_GroupInterrupt); with
  /// 605Dh = 1 they stay on their line. The move and the queue stay. Also of axes that another
  /// session owns, and after Session::interrupt().
  Outcome halt_all(const GroupCallOptions& options = {});

  /// Continues what was halted (000Fh; MC_GroupContinue), done when it has arrived.
  Outcome resume_all(const GroupCallOptions& options = {});

  /// Quick stop (0002h) of every axis without a fault, at once (MC_GroupStop): done when all are at
  /// rest. Drops the queue. Also of axes that another session owns, and after
  /// Session::interrupt().
  Outcome quick_stop_all(const GroupCallOptions& options = {});

  /// Rising edge of bit 7 on every axis with a fault (MC_GroupReset).
  /// @return refused, naming the first axis whose cause persists.
  Outcome reset_all(const GroupCallOptions& options = {});

  /// A command by its name: enable_all(), disable_all(), halt_all(), resume_all(), quick_stop_all()
  /// or reset_all(). EachCommand::power_cycle switches every axis off and on again and drops the
  /// queue.
  Outcome command(EachCommand command, const GroupCallOptions& options = {});

  /// The cyclic synchronous mode of `options.what` on every axis, from rest, without offsets
  /// (60B0h, 60B1h, 60B2h) and with 60C2h = one tick. They stay where they are until the first
  /// set-point comes.
  Outcome start_streaming(const StreamOptions& options = {});

  /// The set-points of the next tick, rounded to whole ones, one frame a bench. In lock-step it
  /// steps one tick and returns its state, with Pace::observe the state before that tick. In real
  /// time it waits until the bench has come within `lead` of the tick before, which paces the
  /// caller, and returns the newest state. A velocity or a torque stays until the next one.
  /// @return failed when an axis failed (the others are stopped), refused when a set-point came
  ///         late or does not fit in its object.
  Result<GroupStatus> stream(const Eigen::VectorXd& set_points);

  /// Back to profile position mode; the axes brake to rest where the stream left them moving.
  /// @return refused, after that, when one of the last set-points came late and was not run.
  Outcome stop_streaming(const GroupCallOptions& options = {});

 private:
  struct State;
  explicit AxisGroup(std::shared_ptr<State> state);

  std::shared_ptr<State> state_;
};

}  // namespace vdrive::client
