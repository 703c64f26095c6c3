// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {

class SessionCore;
struct StartedMove;

/// What a call waits for.
enum class Until : std::uint8_t {
  in_force,  ///< the drive has acted on the command: one tick
  done,      ///< what was commanded is reached
};

/// How long a call may take and what it waits for.
struct CallOptions {
  std::chrono::nanoseconds timeout = std::chrono::seconds(60);  ///< drive time: see Session
  Until until = Until::done;
  bool keep_target = false;  ///< of enable() only: leaves 60FFh, 6042h and 6071h as they are
};

/// A command that several axes may get together: see Session::command_each().
enum class EachCommand : std::uint8_t {
  enable,       ///< Axis::enable()
  disable,      ///< Axis::disable()
  halt,         ///< Axis::halt()
  resume,       ///< Axis::resume()
  quick_stop,   ///< Axis::quick_stop()
  reset_fault,  ///< Axis::reset_fault()
  power_cycle,  ///< Axis::power_cycle()
};

/// A set-point of profile position mode, with the speed and the ramps of this move. What is not
/// given is as the drive has it. What is given has its old value again after the move: 6081h, which
/// the drive takes with the set-point, at once; 6083h and 6084h, which act during the motion, when
/// the call has waited for its end. With Until::in_force, and after a time-out, the ramps stay.
struct MoveOptions {
  std::optional<std::uint32_t> velocity{};      ///< 6081h [UU/s]
  std::optional<std::uint32_t> acceleration{};  ///< 6083h [UU/s²]
  std::optional<std::uint32_t> deceleration{};  ///< 6084h [UU/s²]
  bool queue = false;  ///< after the present move (bit 5 = 0) instead of at once
  CallOptions call{};
};

/// A homing run. What is not given is as the drive has it; what is given stays in the drive.
struct HomingOptions {
  std::optional<std::int8_t> method{};          ///< 6098h: one of kHomingMethods
  std::optional<std::int32_t> offset{};         ///< 607Ch [UU]: position of home
  std::optional<std::uint32_t> search_speed{};  ///< 6099h:1 [UU/s]
  std::optional<std::uint32_t> creep_speed{};   ///< 6099h:2 [UU/s]
  std::optional<std::uint32_t> acceleration{};  ///< 609Ah [UU/s²]
  CallOptions call{};
};

/// The ramps of profile velocity mode. What is not given is as the drive has it; what is given
/// stays in the drive.
struct VelocityOptions {
  std::optional<std::uint32_t> acceleration{};  ///< 6083h [UU/s²]
  std::optional<std::uint32_t> deceleration{};  ///< 6084h [UU/s²]
  CallOptions call{};
};

/// The ramp of profile torque mode. What is given stays in the drive.
struct TorqueOptions {
  std::optional<std::uint32_t> slope{};  ///< 6087h [‰ of rated torque a second]
  CallOptions call{};
};

/// Answer to the read of one object: `value` holds when `code` is AbortCode::none.
struct ObjectReading {
  ObjectAddress object;
  AbortCode code = AbortCode::none;
  std::int64_t value = 0;
};

/// Answer to the read of several objects, all of one tick.
struct Readings {
  std::uint64_t tick = 0;
  std::vector<ObjectReading> objects;  ///< in the order of the request
};

class Motion;

/// One axis of a bench, commanded over the network. A handle: copies refer to the same axis. Calls
/// after the end of its session fail and send nothing.
///
/// Commands acquire the axis for the session, and are refused while another session owns it. Only
/// halt() and quick_stop() act then too: the owner keeps the axis. A command that the power state
/// does not allow is refused with 0x08000022 and changes nothing. `failed` means that the drive
/// accepted the command and that a fault, a lost enable or a halt ended it. A call that waits for a
/// motion ends when another session takes the axis: refused, with that session and its program.
///
/// Positions, velocities or torques for each tick, in the cyclic synchronous modes 8, 9 and 10, are
/// streamed by a group of this one axis: AxisGroup::start_streaming().
class Axis {
 public:
  [[nodiscard]] const AxisId& id() const noexcept { return id_; }

  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  /// What its user units are, as its bench describes it. All calls take and give user units.
  [[nodiscard]] const Unit& unit() const noexcept { return unit_; }

  /// The present state.
  Result<AxisSnapshot> status() const;

  /// Takes control without a command. @return refused when another session holds the axis.
  Outcome acquire();

  /// The same, also from another session: that session loses the axis, and frames of it that wait
  /// are dropped. The axis continues as it is.
  Outcome take_over();

  /// Goes through the power states to Operation enabled. If a quick stop is in progress it waits
  /// for standstill first. A drive may power on for a while: until then it shows Switched on, in
  /// which Until::in_force returns.
  ///
  /// The axis does not move: with the last controlword it gets 0 in 60FFh, 6042h and 6071h, which
  /// another program may have left and which a drive follows at once. With `options.keep_target`
  /// they stay, and the axis may run off. In Operation enabled nothing is written.
  /// @return refused in a fault: reset it first; failed where the drive stays in another state.
  Outcome enable(const CallOptions& options = {});

  /// Shutdown (0006h): to Ready to switch on.
  Outcome disable(const CallOptions& options = {});

  /// Moves to a position [UU]: sets profile position mode if needed, sends the set-point and waits
  /// for bit 10. @return refused when not enabled, when the drive ignores the set-point, where a
  ///         speed or a ramp of 0 allows no motion, and where the given velocity is above 607Fh or
  ///         6080h, as in run_at(); failed when a software limit (607Dh) has cut
  ///         the move off, when a limit switch (60FDh) has ended it, when the axis was halted on
  ///         the way, or when the wait was interrupted: then it continues.
  Outcome move_to(std::int32_t position, const MoveOptions& options = {});

  /// The same by a distance [UU], from the base that 60F2h chooses.
  Outcome move_by(std::int32_t distance, const MoveOptions& options = {});

  /// Starts move_to() and returns when the drive has acknowledged the set-point.
  /// @return a handle to wait on; refused as move_to() is. `options.call.until` is not used.
  Result<Motion> start_move(std::int32_t position, const MoveOptions& options = {});

  /// A homing run (6060h = 6, edge of bit 4): waits until the drive shows homing attained (bit 12)
  /// and is back at home. The axis stays in homing mode; the next move sets its own.
  /// @return failed on a homing error (bit 13) and when a halt or a stop ended the run; refused
  ///         while a run is in progress, and where a given speed is above 607Fh or 6080h.
  Outcome home(const HomingOptions& options = {});

  /// Profile velocity mode (6060h = 3) with 60FFh = `velocity`: waits until it is reached (bit 10).
  /// The axis runs on, also after the call and, once it has reached the velocity, after the
  /// session; 0 brakes it to standstill. After a call that fails the session does not release it:
  /// see Session.
  /// @param velocity [UU/s]
  /// @return refused where a ramp or a limit of 0 allows no motion, and above 607Fh or 6080h;
  ///         failed when a limit switch (60FDh) stops the axis, when the drive limits the velocity
  ///         by the 607Fh and 6080h of its last enabling, when the axis was halted on the way, or
  ///         when the wait was interrupted: then it continues.
  Outcome run_at(std::int32_t velocity, const VelocityOptions& options = {});

  /// Profile torque mode (6060h = 4) with 6071h = `torque`: waits until the torque command has
  /// reached it (bit 10). The torque stays, as the velocity of run_at() does, and an axis without a
  /// load speeds up to the limit of its speed.
  /// @param torque [‰ of rated torque]
  /// @return refused above 6072h, 60E0h or 60E1h; failed when one of them, by way of the rated
  ///         current, or a limit switch (60FDh) keeps the torque back; else as run_at().
  Outcome apply_torque(std::int16_t torque, const TorqueOptions& options = {});

  /// Runs at `velocity` in profile velocity mode while `held` returns true, then brakes and waits
  /// for standstill. Session::interrupt() ends the jog likewise. When this program hangs or dies
  /// meanwhile the watchdog of the bench stops the axis.
  /// However it ends, 60FFh is 0 afterwards, so that the axis does not run on when it is enabled
  /// again; unless the bench is lost, or another session or another call of this one has the axis.
  /// The jog ends, too, when another session takes the axis. When its last command is refused or
  /// its standstill is not seen, it stops the axis by a quick stop, which needs no control; an axis
  /// that another session has commanded since is left to that session.
  /// @param velocity [UU/s]
  /// @param held asked in every tick that is observed; must not wait. When it throws, the axis is
  ///        stopped first
  /// @param options its time-out is that of the start and of the braking
  Outcome jog(std::int32_t velocity, const std::function<bool(const AxisSnapshot&)>& held,
              const VelocityOptions& options = {});

  /// Brakes to standstill in Operation enabled (bit 8); the set-point stays. Also of an axis that
  /// another session owns, and after Session::interrupt().
  Outcome halt(const CallOptions& options = {});

  /// Ends a halt and continues the set-point (000Fh), done when it is reached.
  Outcome resume(const CallOptions& options = {});

  /// Quick stop (0002h): done in Switch on disabled, or at rest where 605Ah keeps the state. Also
  /// of an axis that another session owns, and after Session::interrupt(). Acquires nothing.
  Outcome quick_stop(const CallOptions& options = {});

  /// Rising edge of bit 7, held where a drive does not see a short one. @return refused while the
  /// cause persists, which a drive has 0.1 s of drive time to show. Without a fault it does
  /// nothing.
  Outcome reset_fault(const CallOptions& options = {});

  /// Switches the axis off and on again; the mechanical position is kept.
  Outcome power_cycle(const CallOptions& options = {});

  /// Stores the parameters as they are now (1010h), to be in force after every later power-up, also
  /// of another run of the service. Returns when they are durable; waits for no drive time.
  /// @return refused with 0x08000020 where the service has no state directory, with 0x06060000
  ///         when storing failed: what was stored before stays.
  Outcome store();

  /// Forgets what is stored (1011h): from the next power cycle on the configured values are in
  /// force. Refused as `store` is.
  Outcome restore_defaults();

  /// Reads objects, any number of them. An object that is refused has its code in its place.
  /// @return the values in the order of `objects`. Each kMostObjectsAtOnce of them are one request,
  ///         answered in one tick; `tick` is that of the last request. When one of the requests
  ///         fails, its outcome and no value.
  Result<Readings> read(std::span<const ObjectAddress> objects) const;

  /// Reads one object. @return refused with its abort code.
  Result<std::int64_t> read(ObjectAddress object) const;

  /// Writes an object. @return the tick in which the value is in force, or refused.
  Result<std::uint64_t> write(ObjectAddress object, std::int64_t value);

  /// What move_to() and run_at() ask about the velocity that they are given. A 6081h that is
  /// written is not asked: the drive cuts it without a word.
  /// @param velocity [UU/s]
  /// @return refused above 607Fh, or above 6080h behind the gear (5E11h), naming the limit.
  Outcome check_velocity_limits(std::int64_t velocity) const;

  /// Sets a test-bench input, also of an axis that another session owns. It stays until it is set
  /// again: 0 ends it.
  /// @return the tick in which it is in force, or refused.
  Result<std::uint64_t> disturb(Disturbance disturbance, std::int64_t value = 1);

  /// Ends every disturbance of the axis.
  Outcome end_disturbances();

  /// Checks every tick, the present one included, until `condition` holds.
  /// @param timeout drive time
  Result<AxisSnapshot> wait_until(const std::function<bool(const AxisSnapshot&)>& condition,
                                  std::chrono::nanoseconds timeout) const;

 private:
  friend class AxisGroup;
  friend class Motion;
  friend class Session;
  Axis(std::shared_ptr<SessionCore> core, AxisInfo info);
  Outcome command(EachCommand command, const CallOptions& options);
  Outcome move(std::int32_t target, bool relative, const MoveOptions& options,
               StartedMove* started = nullptr);

  std::shared_ptr<SessionCore> core_;
  AxisId id_;
  std::string name_;
  Unit unit_;
};

/// A move that was started: one set-point. A handle: copies refer to the same set-point. Any later
/// command ends it as failed, even where the axis shows that it has reached a target: a later
/// set-point from any thread of this session, also one with MoveOptions::queue; another mode; a
/// command that leaves Operation enabled; a power cycle; a restored snapshot. The message names it.
/// While the axis is halted the move counts as failed.
class Motion {
 public:
  /// Waits until the axis is at its target.
  /// @param timeout drive time
  /// @return failed when the axis was halted, when another command took the place of the move, when
  ///         a fault, a lost enable, a limit switch or a software limit ended it, and when this
  ///         session gave the axis back; refused when another session took the axis; lost when the
  ///         service was restarted.
  Outcome wait(std::chrono::nanoseconds timeout = std::chrono::seconds(60)) const;

  /// Waits for one sample at most. @return whether the axis is at its target, false while it is on
  ///         its way; where the move has ended otherwise, what wait() returns.
  [[nodiscard]] Result<bool> has_ended() const;

 private:
  friend class Axis;

  Motion(Axis axis, std::shared_ptr<const StartedMove> move)
      : axis_(std::move(axis)), move_(std::move(move)) {}

  Axis axis_;
  std::shared_ptr<const StartedMove> move_;
};

}  // namespace vdrive::client
