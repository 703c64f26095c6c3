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

// State goes into snapshots as it lies in memory. `unused` stands where a compiler would leave
// bytes without a value: equal states are equal bytes, and no file has what was in the memory
// before (tests/core/state_padding_test.cpp).

/// Ticks of a bank, as the drive needs them.
struct TickTiming {
  std::uint32_t period_us = 1000;
  std::uint32_t substeps = 8;
  double substep = 125.0e-6;  // [s]
};

/// The outermost loop that is closed.
enum class ControlLoop : std::uint8_t { position, velocity, torque };

/// What the demand generator is asked for. Two equal requests need no new plan: other loops and
/// other times come with a new target, which makes the request of before void.
struct MotionRequest {
  enum class Kind : std::uint8_t { hold, stop, move, synchronous_move, velocity, torque, follow };

  Kind kind = Kind::hold;
  ControlLoop control = ControlLoop::position;  // the loop that has to be the outermost one
  std::array<std::uint8_t, 6> unused{};
  double target = 0.0;  // moves [UU]; velocity [UU/s]; torque [‰ of rated]; follow: as `control` is
  MotionLimits limits;  // stop: the deceleration; torque: the acceleration is the slope [‰/s]
  MoveTimes times{};    // synchronous move
  MotionJerk jerk{};    // stops, moves, velocity; not limited: trapezoids
  // What the servo gets beside the demand; it needs no new plan.
  double velocity_offset = 0.0;  // added to what the position loop asks for [UU/s]
  double torque_offset = 0.0;    // added to what the velocity loop commands [‰ of rated]

  friend bool operator==(const MotionRequest& a, const MotionRequest& b) noexcept {
    return a.kind == b.kind && a.target == b.target && a.limits.velocity == b.limits.velocity &&
           a.limits.acceleration == b.limits.acceleration &&
           a.limits.deceleration == b.limits.deceleration &&
           a.jerk.acceleration == b.jerk.acceleration && a.jerk.deceleration == b.jerk.deceleration;
  }
};

/// Demand generator, beside the lane of its block.
struct DemandState {
  double torque = 0.0;  // torque control, at the end of the tick [‰ of rated]
  ControlLoop control = ControlLoop::position;
  bool moving = false;     // the profile has not ended
  bool following = false;  // the demand of this tick goes to the streamed one
  bool by_jerk = false;    // the plan is DriveRegisters::jerk_profile
  std::array<std::uint8_t, 4> unused{};
};

/// Where the present motion is to end.
struct TargetState {
  double position = 0.0;   // latched, whole [UU]
  bool given = false;      // a set-point was taken since the set-points were cleared
  bool given_up = false;   // a limit switch ended the motion
  bool arrived = false;    // the demand rests on the target
  bool fresh = false;      // a set-point was taken in this tick
  bool unplanned = false;  // no plan was made since the target was given
  std::array<std::uint8_t, 3> unused{};
};

/// What 6041h needs to have lasted: registers, and the ticks so far.
struct WindowState {
  std::uint32_t position = 0;         // 6067h [UU]
  std::uint32_t position_ticks = 0;   // 6068h
  std::uint32_t velocity = 0;         // 606Dh [UU/s]
  std::uint32_t velocity_ticks = 0;   // 606Eh
  std::uint32_t threshold = 0;        // 606Fh [UU/s]
  std::uint32_t threshold_ticks = 0;  // 6070h
  std::uint32_t dwell = 0;            // ticks inside the window, the present one included; ticks of
                                      // a standing lane are added when that ends
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

/// What bounds the position.
struct LimitState {
  double lower = 0.0;       // 607Dh:01 [UU]
  double upper = 0.0;       // 607Dh:02 [UU]
  bool enabled = false;     // 3535h
  bool homed = false;       // a homing run found home since power-up
  std::uint8_t inputs = 0;  // 60FDh
  bool placed = false;      // a switch has a place (5E21h): the inputs follow the position
  std::array<std::uint8_t, 4> unused{};
};

/// How much of the heat that it may have the motor has (I2t).
enum class LoadLevel : std::uint8_t {
  rated,    // at most that of the rated current
  warning,  // more: bit 7 of 6041h
  fault,    // too much, until it is down to that of the rated current
};

/// Faults: those that are present, and what they mean.
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

/// Power stage.
struct PowerStageState {
  std::uint32_t ticks_in_state = 0;  // steady ticks are not counted: no stop waits in them
  std::uint32_t stop_ticks = 0;      // since the demand of a stop ended
  PowerStateMachine machine;
  bool on = false;
  bool waits = false;  // a habit holds something back (drive/habits.hpp)
};

/// Operating mode.
struct ModeState {
  OperatingMode actual = OperatingMode::none;  // 6061h
  OperatingMode wanted = OperatingMode::none;  // 6060h
};

/// What the operating modes keep between ticks. As it is made here nothing is asked for.
struct ModeStates {
  SetPointState position;
  HomingState homing;
  StreamState stream;
};

/// What every tick touches of an axis.
struct DriveState {
  DemandState demand;
  TargetState target;
  LimitState limits;
  WindowState window;
  FollowingErrorState following_error;
  PowerStageState power;
  FaultState faults;
  ModeState mode;
  std::uint16_t maker_bits = Statusword::kRemote;  // bits 9, 14 and 15 of 6041h, which never change
  ModeStates modes;
  bool attention = true;  // something beside the motion is going on
  bool plan_due = true;   // the motion request may have changed
  std::uint16_t controlword = 0;
  std::uint32_t ignored_set_points = 0;
};

/// What the active set-point latched beside its target.
struct ActiveSetPoint {
  double velocity = 0.0;       // 6081h [UU/s]
  MoveTimes times;             // of a synchronous move; duration 0 = none
  MotionLimits limits;         // that follow from them
  double reference_way = 0.0;  // that the times are of [UU]; 0 = the move itself, from rest
};

/// The way to the set-point that is streamed in a cyclic mode or in interpolated position mode.
struct Interpolation {
  std::int32_t set_point = 0;      // with its offset, as it was when the way began
  std::uint32_t ticks_left = 0;    // of 60C2h, behind the present tick
  std::uint32_t period = 1;        // 60C2h of this way [ticks]
  std::uint32_t silent_ticks = 0;  // since a set-point was written
};

/// Records of interpolated position mode that wait, at most; 60C4h:01.
inline constexpr std::size_t kRecordBufferSize = 16;

/// 60C4h: the records of interpolated position mode that wait.
struct RecordBuffer {
  std::array<std::int32_t, kRecordBufferSize> records{};  // 60C1h:01, from `first` round the end
  std::uint8_t first = 0;
  std::uint8_t count = 0;
  std::array<std::uint8_t, 6> unused{};
};

/// Index pulses of encoder 1.
struct IndexPulse {
  double offset = 0.0;   // of the pulses in the motor's frame [UU]
  double reading = 0.0;  // of encoder 1 in the last tick of a homing run [UU]
  bool input = false;    // 5E09h as it was in the last tick
  std::array<std::uint8_t, 7> unused{};
};

/// Where the frames count from that `shift_frame` moves: the place that was 0 at first power-up.
struct FrameOrigins {
  double motor = 0.0;  // in the frame of encoder 1 [UU]
  double load = 0.0;   // in the frame of the load [UU]
};

/// Position range 607Bh of a modulo axis.
struct PositionRange {
  double lower = 0.0;  // 607Bh:01 [UU]
  double span = 0.0;   // 607Bh:02 less 607Bh:01 [UU]; 0 = no modulo axis
};

/// 1003h.
struct ErrorHistory {
  std::array<std::uint32_t, 8> codes{};  // the latest first
  std::uint8_t count = 0;
  std::array<std::uint8_t, 7> unused{};
};

/// The speed limits in force.
struct SpeedLimits {
  double app_speed_limit = 0.0;      // 607Fh [UU/s]
  double motor_max_speed_rpm = 0.0;  // 6080h [rpm]
};

/// What only writes and plans touch.
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
  SpeedLimits speed_limits{};  // as they were at transition 4
  double velocity_cap = 0.0;   // that follows from them with the gear [UU/s]
  AxisSettings settings;
  bool memory_error = false;    // what was stored cannot be used: fault 5530h at power-up
  bool single_encoder = false;  // 6064h is encoder 1's: both readings share one frame
};

/// One torque unit and the motor's rating in the units of the objects.
struct alignas(64) UnitBlock {
  Lane torque_per_mille;   // 6077h of one torque unit
  Lane current_per_mille;  // 6078h of one torque unit
  Lane rated_current;      // [mA]
};

/// Lanes in which nothing happens but the motion, and what ends that. Bit l of a set is lane l.
struct alignas(64) SteadyBlock {
  Lane following_error_window;  // 6065h; infinite = off [UU]
  Lane target;                  // internal target [UU]
  Lane target_window;           // 6067h [UU]
  std::uint64_t lanes;          // all that are steady
  std::uint64_t standing;       // of these, on the target; DemandBlock::plan_ticks counts how long
  std::uint64_t unpowered;      // of these, without power; only a write ends that
  std::array<std::uint64_t, 5> unused;
};

/// What every tick touches of the axes of a block, side by side.
struct BlockState {
  ServoState servo;
  DemandBlock demand;
  UnitBlock units;
  SteadyBlock steady;
  std::uint64_t noisy;         // lanes whose load torque has noise
  std::uint64_t modulo;        // lanes of modulo axes
  std::uint64_t probed;        // lanes with an enabled touch probe
  std::uint64_t jerk_limited;  // lanes that move along a plan with jerk
  std::uint64_t ticks;   // since the bank began, without those that a settled block leaves out now
  std::uint64_t frozen;  // lanes whose feedback is shown as it was (5E0Ch)
  std::array<std::uint64_t, 2> unused;
};

/// One axis: its state, its lane of the block, its status image. Questions take a
/// `const Drive&`, through which nothing can be changed; commands take a `Drive&`.
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

  Drive(const Drive&) = delete;  // a copy of a constant drive could be changed
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
