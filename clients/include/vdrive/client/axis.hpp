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

/// When a call returns.
enum class Until : std::uint8_t {
  in_force,  ///< once the drive has acted on the command: after one tick
  done,      ///< once the command has reached its goal
};

/// How long a call may take and what it waits for.
struct CallOptions {
  std::chrono::nanoseconds timeout = std::chrono::seconds(60);  ///< drive time: see Session
  Until until = Until::done;
  bool keep_target = false;  ///< enable() only: leaves 60FFh, 6042h and 6071h unchanged
};

/// A command that can be given to several axes together: see Session::command_each().
enum class EachCommand : std::uint8_t {
  enable,       ///< Axis::enable()
  disable,      ///< Axis::disable()
  halt,         ///< Axis::halt()
  resume,       ///< Axis::resume()
  quick_stop,   ///< Axis::quick_stop()
  reset_fault,  ///< Axis::reset_fault()
  power_cycle,  ///< Axis::power_cycle()
};

/// A set-point of profile position mode, with optional speed and ramps for this move. A member
/// without a value leaves the drive's value in force. A given value replaces the drive's for this
/// move only: 6081h is restored immediately, because the drive samples it with the set-point; 6083h
/// and 6084h, which act during the motion, are restored once the call has seen the move end. With
/// Until::in_force, and after a time-out, they are not restored.
struct MoveOptions {
  std::optional<std::uint32_t> velocity{};      ///< 6081h [UU/s]
  std::optional<std::uint32_t> acceleration{};  ///< 6083h [UU/s²]
  std::optional<std::uint32_t> deceleration{};  ///< 6084h [UU/s²]
  bool queue = false;  ///< start after the present move (bit 5 = 0) instead of immediately
  CallOptions call{};
};

/// A homing run. A member without a value leaves the drive's value unchanged; a given value stays
/// in the drive.
struct HomingOptions {
  std::optional<std::int8_t> method{};          ///< 6098h: one of kHomingMethods
  std::optional<std::int32_t> offset{};         ///< 607Ch [UU]: position of home
  std::optional<std::uint32_t> search_speed{};  ///< 6099h:1 [UU/s]
  std::optional<std::uint32_t> creep_speed{};   ///< 6099h:2 [UU/s]
  std::optional<std::uint32_t> acceleration{};  ///< 609Ah [UU/s²]
  CallOptions call{};
};

/// The ramps of profile velocity mode. A member without a value leaves the drive's value unchanged;
/// a given value stays in the drive.
struct VelocityOptions {
  std::optional<std::uint32_t> acceleration{};  ///< 6083h [UU/s²]
  std::optional<std::uint32_t> deceleration{};  ///< 6084h [UU/s²]
  CallOptions call{};
};

/// The ramp of profile torque mode. A given value stays in the drive.
struct TorqueOptions {
  std::optional<std::uint32_t> slope{};  ///< 6087h [‰ of rated torque per second]
  CallOptions call{};
};

/// Result of reading one object: `value` is valid if `code` is AbortCode::none.
struct ObjectReading {
  ObjectAddress object;
  AbortCode code = AbortCode::none;
  std::int64_t value = 0;
};

/// Result of reading several objects, up to kMostObjectsAtOnce of them in one tick.
struct Readings {
  std::uint64_t tick = 0;
  std::vector<ObjectReading> objects;  ///< in the order of the request
};

class Motion;

/// One axis of a bench, commanded over the network. A handle: copies refer to the same axis. After
/// the end of its session, calls fail and send nothing.
///
/// A command acquires the axis for the session and is refused while another session owns it. Only
/// halt() and quick_stop() work even then, and the owner keeps the axis. A command that the power
/// state does not allow is refused with 0x08000022 and changes nothing. `failed` means that the
/// drive accepted the command, but a fault, a loss of Operation enabled or a halt ended it. If
/// another session takes the axis while a call waits for a motion, the call returns refused and
/// names that session and its program.
///
/// To stream positions, velocities or torques tick by tick (cyclic synchronous modes 8, 9 and 10),
/// make a group of this one axis: AxisGroup::start_streaming().
class Axis {
 public:
  [[nodiscard]] const AxisId& id() const noexcept { return id_; }

  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  /// The user units of the axis, as its bench describes them. All calls take and return user units.
  [[nodiscard]] const Unit& unit() const noexcept { return unit_; }

  /// The present state.
  Result<AxisSnapshot> status() const;

  /// Takes control without a command.
  /// @return refused if another session holds the axis.
  Outcome acquire();

  /// As acquire(), but also takes the axis from another session. That session loses the axis, and
  /// its command frames for the axis that still wait for their tick are dropped. The motion of the
  /// axis is not affected.
  Outcome take_over();

  /// Takes the axis through the power states to Operation enabled. If a quick stop is in progress,
  /// waits for standstill first. A drive may take time to power on: until then it shows Switched
  /// on, and Until::in_force returns in that state.
  ///
  /// The axis does not move: together with the last controlword, the call sets 60FFh, 6042h and
  /// 6071h to 0, because another program may have left values there that a drive would follow
  /// immediately. With `options.keep_target` they keep their values, and the axis may start moving.
  /// If the axis is in Operation enabled already, nothing is written.
  /// @return refused in a fault: reset it first; failed if the drive stays in another state.
  Outcome enable(const CallOptions& options = {});

  /// Shutdown (0006h): goes to Ready to switch on.
  Outcome disable(const CallOptions& options = {});

  /// Moves to a position [UU]: selects profile position mode if needed, sends the set-point and
  /// waits for bit 10.
  /// @return refused if the axis is not enabled, the drive ignores the set-point, a speed or a ramp
  ///         of 0 allows no motion, or the given velocity is above 607Fh or 6080h, as in run_at();
  ///         failed if a software limit (607Dh) cut the move short, a limit switch (60FDh) ended
  ///         it, the axis was halted on the way, or the wait was interrupted: in that case the
  ///         motion continues.
  Outcome move_to(std::int32_t position, const MoveOptions& options = {});

  /// As move_to(), but by a distance [UU] from the base that 60F2h selects.
  Outcome move_by(std::int32_t distance, const MoveOptions& options = {});

  /// Starts move_to() and returns when the drive has acknowledged the set-point.
  /// @return a handle to wait on; refused as move_to() is. `options.call.until` is not used.
  Result<Motion> start_move(std::int32_t position, const MoveOptions& options = {});

  /// Runs homing (6060h = 6, rising edge of bit 4) and waits until the drive shows homing attained
  /// (bit 12) and is back at the home position. The axis stays in homing mode; the next move
  /// selects its own mode.
  /// @return failed on a homing error (bit 13) or if a halt or a stop ended the run; refused while
  ///         a run is in progress, or if a given speed is above 607Fh or 6080h.
  Outcome home(const HomingOptions& options = {});

  /// Profile velocity mode (6060h = 3) with 60FFh = `velocity`: waits until it is reached (bit 10).
  /// The axis keeps running after the call and, if it has reached the velocity, also after the
  /// session; 0 brakes it to standstill. After a call that fails, the session does not release the
  /// axis: see Session.
  /// @param velocity [UU/s]
  /// @return refused if a ramp or a limit of 0 allows no motion, or if `velocity` is above 607Fh or
  ///         6080h; failed if a limit switch (60FDh) stops the axis, the drive limits the velocity
  ///         to the values that 607Fh and 6080h had when it was last enabled, the axis was halted
  ///         on the way, or the wait was interrupted: in that case the motion continues.
  Outcome run_at(std::int32_t velocity, const VelocityOptions& options = {});

  /// Profile torque mode (6060h = 4) with 6071h = `torque`: waits until the torque command has
  /// reached it (bit 10). The torque stays after the call, as the velocity of run_at() does, and an
  /// axis without a load accelerates to its speed limit.
  /// @param torque [‰ of rated torque]
  /// @return refused if `torque` is beyond 6072h, 60E0h or 60E1h; failed if one of them (converted
  ///         through the rated current) or a limit switch (60FDh) limits the torque; otherwise as
  ///         run_at().
  Outcome apply_torque(std::int16_t torque, const TorqueOptions& options = {});

  /// Runs at `velocity` in profile velocity mode while `held` returns true, then brakes and waits
  /// for standstill. Session::interrupt() ends the jog in the same way, and so does another session
  /// that takes the axis. If this program hangs or dies during the jog, the watchdog of the bench
  /// stops the axis.
  ///
  /// However the jog ends, it leaves 60FFh at 0, so that the axis does not start moving when it is
  /// next enabled. The only exceptions: the bench is lost, or another session or another call of
  /// this session has the axis. If the last command is refused or no standstill is seen, the call
  /// stops the axis with a quick stop, which works without owning the axis; an axis that another
  /// session has commanded since then is left to that session.
  /// @param velocity [UU/s]
  /// @param held called in every observed tick; must not block. If it throws, the axis is stopped
  ///        first
  /// @param options its time-out applies to the start and to the braking
  Outcome jog(std::int32_t velocity, const std::function<bool(const AxisSnapshot&)>& held,
              const VelocityOptions& options = {});

  /// Brakes to standstill in Operation enabled (bit 8); the set-point stays. Also works on an axis
  /// that another session owns, and after Session::interrupt().
  Outcome halt(const CallOptions& options = {});

  /// Ends a halt and continues to the set-point (000Fh); done when it is reached.
  Outcome resume(const CallOptions& options = {});

  /// Quick stop (0002h): done in Switch on disabled, or at rest if 605Ah keeps the state. Also
  /// works on an axis that another session owns, and after Session::interrupt(). Does not acquire
  /// the axis.
  Outcome quick_stop(const CallOptions& options = {});

  /// A pulse of bit 7, repeated as a longer one for drives that miss the first. Does nothing
  /// without a fault.
  /// @return refused if the fault lasts for another 0.1 s of drive time: its cause persists.
  Outcome reset_fault(const CallOptions& options = {});

  /// Switches the axis off and on again; the mechanical position is kept.
  Outcome power_cycle(const CallOptions& options = {});

  /// Stores the present parameters (1010h): they are in force after every later power-up, also in
  /// another run of the service. Returns when they are stored durably; does not wait for drive
  /// time.
  /// @return refused with 0x08000020 if the service has no state directory, with 0x06060000 if
  ///         storing failed: the parameters stored before stay.
  Outcome store();

  /// Discards the stored parameters (1011h): from the next power cycle the configured values are in
  /// force. Refused as store() is.
  Outcome restore_defaults();

  /// Reads any number of objects. A refused object has its abort code in its place.
  /// @return the values in the order of `objects`. Each request reads up to kMostObjectsAtOnce of
  ///         them in one tick; `tick` is that of the last request. If a request fails, its outcome
  ///         is returned and no values.
  Result<Readings> read(std::span<const ObjectAddress> objects) const;

  /// Reads one object.
  /// @return refused with its abort code.
  Result<std::int64_t> read(ObjectAddress object) const;

  /// Writes an object.
  /// @return the tick in which the value is in force, or refused.
  Result<std::uint64_t> write(ObjectAddress object, std::int64_t value);

  /// The velocity check of move_to() and run_at(). A direct write to 6081h bypasses it: the drive
  /// silently limits that value.
  /// @param velocity [UU/s]
  /// @return refused above 607Fh, or above 6080h converted through the gear (5E11h), naming the
  ///         limit.
  Outcome check_velocity_limits(std::int64_t velocity) const;

  /// Sets a test-bench input, also on an axis that another session owns. The value stays until it
  /// is set again; 0 ends the disturbance.
  /// @return the tick in which it is in force, or refused.
  Result<std::uint64_t> disturb(Disturbance disturbance, std::int64_t value = 1);

  /// Ends every disturbance of the axis.
  Outcome end_disturbances();

  /// Checks `condition` in every tick, the present one included, until it holds.
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
/// command ends it as failed, even if the axis shows that it has reached a target: a later
/// set-point from any thread of this session, also one with MoveOptions::queue; a change of mode; a
/// command that leaves Operation enabled; a power cycle; a restored snapshot. The message names the
/// command. A move also counts as failed while the axis is halted.
class Motion {
 public:
  /// Waits until the axis is at its target.
  /// @param timeout drive time
  /// @return failed if the axis was halted, another command replaced the move, a fault, a loss of
  ///         Operation enabled, a limit switch or a software limit ended it, or this session
  ///         released the axis; refused if another session took the axis; lost if the service was
  ///         restarted.
  Outcome wait(std::chrono::nanoseconds timeout = std::chrono::seconds(60)) const;

  /// Waits for at most one sample.
  /// @return whether the axis is at its target, false while it is on its way; if the move has ended
  ///         in any other way, the outcome that wait() would return.
  [[nodiscard]] Result<bool> has_ended() const;

 private:
  friend class Axis;

  Motion(Axis axis, std::shared_ptr<const StartedMove> move)
      : axis_(std::move(axis)), move_(std::move(move)) {}

  Axis axis_;
  std::shared_ptr<const StartedMove> move_;
};

}  // namespace vdrive::client
