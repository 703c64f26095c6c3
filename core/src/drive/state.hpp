// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/habits_state.hpp"
#include "drive/modes/homing_state.hpp"
#include "drive/modes/profile_position_state.hpp"
#include "drive/modes/stream_state.hpp"
#include "drive/probe_state.hpp"
#include "plant/servo_block.hpp"
#include "vdrive/axis_configuration.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state_machine.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/motion/jerk_profile.hpp"
#include "vdrive/motion/profile.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdrive {

// State is copied into snapshots as it is laid out in memory. `unused` fills what would be padding,
// so that equal states are equal bytes and no old memory content gets into a file
// (tests/core/state_padding_test.cpp).

/// Tick timing of a bank, as the drive needs it.
struct TickTiming {
  std::uint32_t period_us = 1000;
  std::uint32_t substeps = 8;
  double substep = 125.0e-6;  // [s]
};

/// The outermost closed loop.
enum class ControlLoop : std::uint8_t { position, velocity, torque };

/// A request to the demand generator. Equal requests need no new plan. `control` and `times` are
/// not compared: they change only together with a new target, which invalidates the previous
/// request.
struct MotionRequest {
  enum class Kind : std::uint8_t { hold, stop, move, synchronous_move, velocity, torque, follow };

  Kind kind = Kind::hold;
  ControlLoop control = ControlLoop::position;  // the loop to be the outermost one
  std::array<std::uint8_t, 6> unused{};
  double target = 0.0;  // [UU], [UU/s] or [‰ of rated], by `kind`; follow: by `control`
  MotionLimits limits;  // stop: the deceleration; torque: the acceleration is the slope [‰/s]
  MoveTimes times{};    // synchronous move
  MotionJerk jerk{};    // stops, moves, velocity; unlimited = trapezoidal profile
  // Inputs of the servo in addition to the demand; they need no new plan.
  double velocity_offset = 0.0;  // added to the output of the position loop [UU/s]
  double torque_offset = 0.0;    // added to the output of the velocity loop [‰ of rated]

  friend bool operator==(const MotionRequest& a, const MotionRequest& b) noexcept {
    return a.kind == b.kind && a.target == b.target && a.limits.velocity == b.limits.velocity &&
           a.limits.acceleration == b.limits.acceleration &&
           a.limits.deceleration == b.limits.deceleration &&
           a.jerk.acceleration == b.jerk.acceleration && a.jerk.deceleration == b.jerk.deceleration;
  }
};

/// State of the demand generator, apart from its lane in DemandBlock.
struct DemandState {
  double torque = 0.0;  // torque control, at the end of the tick [‰ of rated]
  ControlLoop control = ControlLoop::position;
  bool moving = false;     // the profile has not ended
  bool following = false;  // the demand of this tick goes to the streamed set-point
  bool by_jerk = false;    // the plan is DriveRegisters::jerk_profile
  std::array<std::uint8_t, 4> unused{};
};

/// The target of the present motion.
struct TargetState {
  double position = 0.0;   // latched, rounded [UU]
  bool given = false;      // a set-point was taken since targets were last dropped
  bool given_up = false;   // a limit switch ended the motion
  bool arrived = false;    // the demand rests on the target
  bool fresh = false;      // a set-point was taken in this tick
  bool unplanned = false;  // no plan has been made since the target was given
  std::array<std::uint8_t, 3> unused{};
};

/// Conditions that must last before 6041h shows them: limits, and the ticks so far.
struct WindowState {
  std::uint32_t position = 0;         // 6067h [UU]
  std::uint32_t position_ticks = 0;   // 6068h
  std::uint32_t velocity = 0;         // 606Dh [UU/s]
  std::uint32_t velocity_ticks = 0;   // 606Eh
  std::uint32_t threshold = 0;        // 606Fh [UU/s]
  std::uint32_t threshold_ticks = 0;  // 6070h
  std::uint32_t dwell = 0;            // ticks inside the window, the present one included; those in
                                      // which the lane was steady are added by end_steadiness
  std::uint32_t standstill = 0;       // ticks at or below 606Fh, the present one included
};

/// Following error 60F4h.
struct FollowingErrorState {
  std::uint32_t window = 0;  // 6065h [UU]
  std::uint32_t ticks = 0;   // 6066h
  std::uint32_t count = 0;   // ticks outside the window
  bool shown = false;        // statusword bit 13
  std::array<std::uint8_t, 3> unused{};
};

struct LimitState {
  double lower = 0.0;       // 607Dh:01 [UU]
  double upper = 0.0;       // 607Dh:02 [UU]
  bool enabled = false;     // 3535h
  bool homed = false;       // a homing run found home since power-up
  std::uint8_t inputs = 0;  // 60FDh
  bool placed = false;      // a switch has a position (5E21h): the inputs follow the axis
  std::array<std::uint8_t, 4> unused{};
};

/// Motor heat relative to what is allowed (I2t).
enum class LoadLevel : std::uint8_t {
  rated,    // at most the heat at rated current
  warning,  // more: bit 7 of 6041h
  fault,    // too much; lasts until the heat is back in the range of `rated`
};

/// Present faults and their effects.
struct FaultState {
  std::uint32_t count = 0;  // since power-up
  std::uint16_t error_code = 0;
  std::uint8_t error_register = 0;
  std::uint8_t causes = 0;  // fault causes present in the last tick
  bool coasting = false;    // the fault allows no braking
  bool dc_link = true;
  LoadLevel load_level = LoadLevel::rated;
  std::array<std::uint8_t, 1> unused{};
};

struct PowerStageState {
  std::uint32_t ticks_in_state = 0;  // steady ticks not counted: no stop is pending in them
  std::uint32_t stop_ticks = 0;      // since the demand of a stop ended
  PowerStateMachine machine;
  bool on = false;
  bool waits = false;  // a habit is holding something back (drive/habits.hpp)
};

struct ModeState {
  OperatingMode actual = OperatingMode::none;  // 6061h
  OperatingMode wanted = OperatingMode::none;  // 6060h
};

/// State that the operating modes keep between ticks. By default nothing is requested.
struct ModeStates {
  SetPointState position;
  HomingState homing;
  StreamState stream;
};

/// State of an axis that every tick uses.
struct DriveState {
  DemandState demand;
  TargetState target;
  LimitState limits;
  WindowState window;
  FollowingErrorState following_error;
  PowerStageState power;
  FaultState faults;
  ModeState mode;
  std::uint16_t manufacturer_bits =
      Statusword::kRemote;  // bits 9, 14 and 15 of 6041h, which are constant
  ModeStates modes;
  bool attention = true;  // something apart from the motion is going on
  bool plan_due = true;   // the motion request may have changed
  std::uint16_t controlword = 0;
  std::uint32_t ignored_set_points = 0;
};

/// Values that the active set-point latched in addition to its target.
struct ActiveSetPoint {
  double velocity = 0.0;       // 6081h [UU/s]
  MoveTimes times;             // of a synchronous move; duration 0 = none
  MotionLimits limits;         // derived from the times
  double reference_way = 0.0;  // to which the times apply [UU]; 0 = the move itself, from rest
};

/// Interpolation to the set-point streamed in a cyclic mode or in interpolated position mode.
struct Interpolation {
  std::int32_t set_point = 0;      // with its offset, when the interpolation started
  std::uint32_t ticks_left = 0;    // of 60C2h, after the present tick
  std::uint32_t period = 1;        // 60C2h of this interpolation [ticks]
  std::uint32_t silent_ticks = 0;  // since a set-point was written
};

/// Capacity of the record buffer of interpolated position mode; 60C4h:01.
inline constexpr std::size_t kRecordBufferSize = 16;

/// 60C4h: the waiting records of interpolated position mode.
struct RecordBuffer {
  std::array<std::int32_t, kRecordBufferSize> records{};  // 60C1h:01, a ring starting at `first`
  std::uint8_t first = 0;
  std::uint8_t count = 0;
  std::array<std::uint8_t, 6> unused{};
};

/// Index pulses of encoder 1.
struct IndexPulse {
  double offset = 0.0;   // of the pulses in the frame of the motor [UU]
  double reading = 0.0;  // of encoder 1 in the last tick of a homing run [UU]
  bool input = false;    // 5E09h in the last tick
  std::array<std::uint8_t, 7> unused{};
};

/// Present positions of the points that were at 0 at first power-up; `shift_frame` updates them.
struct FrameOrigins {
  double motor = 0.0;  // in the frame of encoder 1 [UU]
  double load = 0.0;   // in the frame of the load [UU]
};

/// Position range 607Bh of a modulo axis.
struct PositionRange {
  double lower = 0.0;  // 607Bh:01 [UU]
  double span = 0.0;   // 607Bh:02 minus 607Bh:01 [UU]; 0 = not a modulo axis
};

/// Error history 1003h.
struct ErrorHistory {
  std::array<std::uint32_t, 8> codes{};  // latest first
  std::uint8_t count = 0;
  std::array<std::uint8_t, 7> unused{};
};

/// The speed limits in force.
struct SpeedLimits {
  double app_speed_limit = 0.0;      // 607Fh [UU/s]
  double motor_max_speed_rpm = 0.0;  // 6080h [rpm]
};

/// State that not every tick uses.
struct DriveRegisters {
  std::array<std::int64_t, kObjectCount> values{};
  Profile profile;
  JerkProfile jerk_profile;
  MotionRequest request;
  ActiveSetPoint set_point;
  Interpolation interpolation;
  Habits habits;
  HabitWaits waits;
  RecordBuffer record_buffer;
  IndexPulse index;
  FrameOrigins origins;
  HomingRun homing;
  PositionRange range;
  TouchProbeState touch_probe;
  ErrorHistory history;
  double gear_ratio = 1.0;     // 3576h over 3577h
  double position_gain = 1.0;  // of the position loop [1/s]
  double torque_offset = 0.0;  // part of the integrator that is an offset [UU/s²]
  SpeedLimits speed_limits{};  // from transition 4
  double velocity_cap = 0.0;   // derived from speed_limits and the gear [UU/s]
  AxisSettings settings;
  bool memory_error = false;    // the stored values are unusable: fault 5530h at power-up
  bool single_encoder = false;  // 6064h is from encoder 1: both readings share one frame
};

/// A torque of 1 UU/s² and the rated current of the motor, in the units of the objects.
struct alignas(64) UnitBlock {
  Lane torque_per_mille;   // 6077h at a torque of 1 UU/s² [‰]
  Lane current_per_mille;  // 6078h at a torque of 1 UU/s² [‰]
  Lane rated_current;      // [mA]
};

/// Steady lanes (drive/tick.hpp), in which only the motion continues, and the conditions that end
/// this. Bit l of a set is lane l.
struct alignas(64) SteadyBlock {
  Lane following_error_window;  // 6065h; infinite = off [UU]
  Lane target;                  // internal target [UU]
  Lane target_window;           // 6067h [UU]
  std::uint64_t lanes;          // all steady lanes
  std::uint64_t standing;       // of these, on the target; plan_ticks counts their steady ticks
  std::uint64_t unpowered;      // of these, without power; only a write ends this
  std::array<std::uint64_t, 5> unused;
};

/// State of the axes of a block that every tick uses, lane by lane.
struct BlockState {
  ServoState servo;
  DemandBlock demand;
  UnitBlock units;
  SteadyBlock steady;
  std::uint64_t noisy;         // lanes whose load torque has noise
  std::uint64_t modulo;        // lanes of modulo axes
  std::uint64_t probed;        // lanes with an enabled touch probe
  std::uint64_t jerk_limited;  // lanes that follow a plan with limited jerk
  std::uint64_t ticks;   // since the bank started; ticks skipped while settled are added afterwards
  std::uint64_t frozen;  // lanes whose feedback is frozen (5E0Ch)
  std::array<std::uint64_t, 2> unused;
};

/// One axis: its state, its lane of the block and its status image. Questions take a `const
/// Drive&`, through which nothing can be changed; commands take a `Drive&`.
class Drive {
 public:
  Drive(DriveState& state, DriveRegisters& registers, BlockState& block, std::size_t lane,
        AxisStatus& status, const TickTiming& timing) noexcept
      : state_(state),
        registers_(registers),
        block_(block),
        lane_(lane),
        status_(status),
        timing_(timing) {}

  Drive(const Drive&) = delete;  // a copy of a const drive would allow changes
  Drive& operator=(const Drive&) = delete;
  ~Drive() = default;

  [[nodiscard]] DriveState& state() noexcept { return state_; }

  [[nodiscard]] const DriveState& state() const noexcept { return state_; }

  [[nodiscard]] DriveRegisters& registers() noexcept { return registers_; }

  [[nodiscard]] const DriveRegisters& registers() const noexcept { return registers_; }

  [[nodiscard]] BlockState& block() noexcept { return block_; }

  [[nodiscard]] const BlockState& block() const noexcept { return block_; }

  [[nodiscard]] ServoState& servo() noexcept { return block_.servo; }

  [[nodiscard]] const ServoState& servo() const noexcept { return block_.servo; }

  [[nodiscard]] DemandBlock& demand() noexcept { return block_.demand; }

  [[nodiscard]] const DemandBlock& demand() const noexcept { return block_.demand; }

  [[nodiscard]] AxisStatus& status() noexcept { return status_; }

  [[nodiscard]] const AxisStatus& status() const noexcept { return status_; }

  [[nodiscard]] std::size_t lane() const noexcept { return lane_; }

  [[nodiscard]] const TickTiming& timing() const noexcept { return timing_; }

 private:
  DriveState& state_;
  DriveRegisters& registers_;
  BlockState& block_;
  std::size_t lane_;
  AxisStatus& status_;
  const TickTiming& timing_;
};

}  // namespace vdrive
