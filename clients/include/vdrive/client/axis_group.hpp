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

/// The state of a group, named as in PLCopen part 4.
enum class GroupState : std::uint8_t {
  disabled,    ///< at least one axis is not in Operation enabled
  standby,     ///< enabled and at rest
  moving,      ///< enabled and on the way
  stopping,    ///< a quick stop is in progress
  error_stop,  ///< at least one axis has a fault
};

/// @return the name of the state, such as "error_stop".
[[nodiscard]] std::string_view to_string(GroupState state) noexcept;

/// All axes of a group after one tick. Vectors and axes are in the group's order.
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
  double fraction = 0.0;   ///< completed part of the present move, 0 to 1; 0 without a move
  std::span<const AxisSnapshot> axes;
};

/// How long a call may take, when it returns, and a callback that observes it.
struct GroupCallOptions {
  /// Drive time. Default: 60 s; for a move, its duration plus 5 s.
  std::optional<std::chrono::nanoseconds> timeout{};
  Until until = Until::done;
  /// Called at every tick that the call observes, on the calling thread. It must not call the
  /// group.
  std::function<void(const GroupProgress&)> progress{};
  bool keep_target = false;  ///< enable_all() only: see CallOptions
};

/// Factors on the limits of each axis, 0 < factor <= 1 (PLCopen: MC_GroupSetOverride). Each axis
/// moves within its own 6081h, 6083h and 6084h, bounded by 607Fh, 6080h, 60C5h and 60C6h.
struct GroupMoveOptions {
  double velocity_factor = 1.0;
  double acceleration_factor = 1.0;
  double deceleration_factor = 1.0;
  GroupCallOptions call{};
};

/// The quantity that a group streams, in the corresponding cyclic synchronous mode.
enum class Streamed : std::uint8_t {
  positions,   ///< 607Ah [UU], 6060h = 8
  velocities,  ///< 60FFh [UU/s], 6060h = 9
  torques,     ///< 6071h [‰ of rated torque], 6060h = 10
};

/// How a group streams set-points.
struct StreamOptions {
  /// In real time, how long before its tick each set-point is sent.
  std::chrono::nanoseconds lead = std::chrono::milliseconds(10);
  Pace pace = Pace::drive;  ///< lock-step: whether each set-point steps one tick
  Streamed what = Streamed::positions;
};

/// Axes that move together, on one bench or on several that share a clock. A handle: copies refer
/// to the same group. After the end of its session, calls fail.
///
/// Each command goes out as one frame per bench with all its axes, so that they act on it in the
/// same tick. This also holds across benches: in lock-step the group steps them together; in real
/// time, with equal periods, rate 1 and synchronised clocks, commands that must act together carry
/// the number of the tick in which they take effect.
///
/// Messages name the axis that refused, failed or was late. A call that waits for motion checks
/// every axis. If one has a fault, loses Operation enabled, belongs to a service that stops
/// sending, is taken by another session or gets another command from this session, the group
/// immediately sends the others a quick stop (605Ah). Once they are at rest, the call returns
/// `failed`, `lost`, or `refused` with the session that took the axis; an axis that was taken is
/// left to that session, and one that got another command carries on with that command. While no
/// call waits, poll() makes the same checks, and so does monitor(), except that it does not look
/// for other commands. A call that times out does not affect the motion.
///
/// One call at a time, except that in real time halt_all() and quick_stop_all() may be called from
/// another thread.
class AxisGroup {
 public:
  /// @param axes addresses or names, each once; at most kMostAxesAtOnce per bench
  /// @return not_found; refused if an axis appears twice or the benches do not share a clock.
  static Result<AxisGroup> create(Session& session, std::span<const std::string> axes);

  /// As above, for axes that this session has found.
  static Result<AxisGroup> create(Session& session, std::span<const Axis> axes);

  /// The axes in the order of the group.
  [[nodiscard]] std::vector<AxisId> axes() const;

  /// The present state of all axes.
  Result<GroupStatus> status() const;

  /// Takes control of every axis, also from other sessions, which lose it. The motion of the axes
  /// is not affected.
  Outcome take_over();

  /// Brings every axis to Operation enabled (MC_GroupEnable), waiting as long as its drive needs.
  /// No axis moves: see Axis::enable().
  /// @return refused, with nothing sent, if an axis has a fault.
  Outcome enable_all(const GroupCallOptions& options = {});

  /// Shutdown (0006h) of every axis without a fault (MC_GroupDisable). Drops the queue.
  Outcome disable_all(const GroupCallOptions& options = {});

  /// Moves to absolute positions [UU, rounded to integers] along a straight line in axis space
  /// (MC_MoveLinearAbsolute): all axes start in the same tick, keep the ratio of their distances
  /// and arrive in the same tick; the slowest runs at its limit. The axes must be at rest or moving
  /// along a line of this group. In motion, the new target must be on that line: beyond its end,
  /// short of it, or back towards its start. Drops the queue.
  ///
  /// From rest, the times are computed for distances half a unit longer, because an axis at rest
  /// may be up to half a unit away from the position in 6062h. In motion, the axes stay on their
  /// line and arrive together, apart from the rounding to integers.
  /// @return refused, with nothing changed, if an axis cannot take part: it is not enabled, its
  ///         target is beyond its software limits, its move would take more than 4294 s, or it is
  ///         moving, and its demand (6062h, 606Bh) or its target is off the line; the message then
  ///         gives this value and the value that it should have. If an axis ignores its set-point,
  ///         the others do not start in lock-step; in real time, or if they were already moving,
  ///         they are halted.
  Outcome move_together(const Eigen::VectorXd& targets, const GroupMoveOptions& options = {});

  /// As move_together(), by displacements from the demand positions (MC_MoveLinearRelative).
  Outcome move_by(const Eigen::VectorXd& displacements, const GroupMoveOptions& options = {});

  /// Appends a move_together() (buffer mode mcBuffered). It starts in wait_all() or poll() as soon
  /// as the demand positions of the previous move have arrived, without waiting for the position
  /// windows; in lock-step without a tick in between. `options.call` is not used.
  Outcome queue_move(const Eigen::VectorXd& targets, const GroupMoveOptions& options = {});

  /// Waits until the present move and the queue have ended. The default time-out applies to each
  /// move. A halt keeps the queue; a fault, a refusal, a quick stop and a disable drop it.
  Outcome wait_all(const GroupCallOptions& options = {});

  /// Checks the group once, without stepping: stops the others if an axis failed, and starts the
  /// next queued move if the last one has arrived. For a program with its own loop.
  Result<GroupStatus> poll();

  /// Real time: checks for faults on a separate thread while no call waits.
  /// @return refused in lock-step, where time stands still between calls: use poll().
  Outcome monitor(bool on);

  /// Brakes the enabled axes to standstill as 605Dh selects (010Fh; MC_GroupHalt,
  /// MC_GroupInterrupt); with 605Dh = 1 they stay on their line. The move and the queue stay. Also
  /// works on axes that another session owns, and after Session::interrupt().
  Outcome halt_all(const GroupCallOptions& options = {});

  /// Continues a halted move (000Fh; MC_GroupContinue); done on arrival.
  Outcome resume_all(const GroupCallOptions& options = {});

  /// Immediate quick stop (0002h) of every axis without a fault (MC_GroupStop): done when all are
  /// at rest. Drops the queue. Also works on axes that another session owns, and after
  /// Session::interrupt().
  Outcome quick_stop_all(const GroupCallOptions& options = {});

  /// Rising edge of bit 7 on every axis with a fault (MC_GroupReset).
  /// @return refused, naming the first axis whose cause persists.
  Outcome reset_all(const GroupCallOptions& options = {});

  /// Runs a command given by its name: enable_all(), disable_all(), halt_all(), resume_all(),
  /// quick_stop_all() or reset_all(). EachCommand::power_cycle switches every axis off and on again
  /// and drops the queue.
  Outcome command(EachCommand command, const GroupCallOptions& options = {});

  /// Selects the cyclic synchronous mode of `options.what` on every axis, from rest, with one
  /// set-point per tick (60C2h:01 = 0) and the offsets 60B0h, 60B1h and 60B2h set to 0. The axes
  /// hold their positions until the first set-point arrives.
  Outcome start_streaming(const StreamOptions& options = {});

  /// Sends the set-points of the next tick, rounded to integers, in one frame per bench. In
  /// lock-step with Pace::drive, it steps one tick and returns the state after it; with
  /// Pace::observe, it does not step and returns the state before that tick. In real time it waits
  /// until the bench is within `lead` of the tick of these set-points, and returns the newest
  /// state; the wait paces the caller. A velocity or a torque stays in force until the next one.
  /// @return failed if an axis failed (the others are stopped), refused if a set-point was late or
  ///         does not fit in its object.
  Result<GroupStatus> stream(const Eigen::VectorXd& set_points);

  /// Returns to profile position mode; axes that the stream left moving brake to rest.
  /// @return refused afterwards if one of the last set-points arrived late and was not executed.
  Outcome stop_streaming(const GroupCallOptions& options = {});

 private:
  struct State;
  explicit AxisGroup(std::shared_ptr<State> state);

  std::shared_ptr<State> state_;
};

}  // namespace vdrive::client
