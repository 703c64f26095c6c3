// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plant/servo_block.hpp"
#include "vdrive/axis_configuration.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state_machine.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/motion/profile.hpp"
#include "vdrive/motion/set_point_queue.hpp"

#include <array>
#include <cstdint>

namespace vdrive {

/// Ticks of a bank, as the drive needs them.
struct TickTiming {
  std::uint32_t period_us = 1000;
  std::uint32_t substeps = 8;
  double substep = 125.0e-6;  // [s]
};

/// What the demand generator is asked for. Two equal requests need no new plan.
struct MotionRequest {
  enum class Kind : std::uint8_t { hold, stop, move, synchronous_move, velocity, torque, follow };

  Kind kind = Kind::hold;
  double target = 0.0;  // moves, follow [UU]; velocity [UU/s]; torque [‰ of rated]
  MotionLimits limits;  // stop: the deceleration; torque: the acceleration is the slope [‰/s]

  friend bool operator==(const MotionRequest& a, const MotionRequest& b) noexcept {
    return a.kind == b.kind && a.target == b.target && a.limits.velocity == b.limits.velocity &&
           a.limits.acceleration == b.limits.acceleration &&
           a.limits.deceleration == b.limits.deceleration;
  }
};

/// The outermost loop that is closed.
enum class Control : std::uint8_t { position, velocity, torque };

/// Where a homing run is.
enum class HomingStage : std::uint8_t {
  idle,     // not started, or interrupted
  present,  // the present position is home
  search,   // towards the limit switch
  leave,    // away from it
  index,    // towards the next index pulse
  back,     // home is known: back to it
  done,
  failed,
};

/// What every tick touches of an axis.
struct DriveState {
  Segment segment;                       // of the profile, now; a resting one between motions
  double plan_ticks = 0.0;               // since the plan
  double demand_position = 0.0;          // [UU]
  double demand_velocity = 0.0;          // [UU/s]
  double target = 0.0;                   // latched internal target, whole [UU]
  double demand_torque = 0.0;            // profile torque, at the end of the tick [‰ of rated]
  double torque_per_mille = 0.0;         // 6077h of one torque unit
  double current_per_mille = 0.0;        // 6078h of one torque unit
  double rated_current = 0.0;            // [mA]
  double lower_limit = 0.0;              // 607Dh:01 [UU]
  double upper_limit = 0.0;              // 607Dh:02 [UU]
  std::uint32_t window = 0;              // 6067h [UU]
  std::uint32_t window_ticks = 0;        // 6068h
  std::uint32_t dwell = 0;               // ticks inside the window, the present one included
  std::uint32_t standstill = 0;          // ticks at or below 606Fh, the present one included
  std::uint32_t following_window = 0;    // 6065h [UU]
  std::uint32_t following_ticks = 0;     // 6066h
  std::uint32_t following_count = 0;     // ticks outside the window
  std::uint32_t velocity_threshold = 0;  // 606Fh [UU/s]
  std::uint32_t velocity_threshold_ticks = 0;  // 6070h
  std::uint32_t velocity_window = 0;           // 606Dh [UU/s]
  std::uint32_t velocity_window_ticks = 0;     // 606Eh
  std::uint32_t ticks_in_state = 0;
  std::uint32_t ignored_set_points = 0;
  std::uint32_t fault_count = 0;
  std::uint16_t controlword = 0;
  std::uint16_t error_code = 0;
  OperatingMode mode = OperatingMode::none;         // 6061h
  OperatingMode wanted_mode = OperatingMode::none;  // 6060h
  Control control = Control::position;
  HomingStage homing = HomingStage::idle;
  std::uint8_t error_register = 0;
  std::uint8_t inputs = 0;  // 60FDh
  std::uint8_t causes = 0;  // fault causes present in the last tick
  PowerStateMachine power;
  SetPointQueue queue;
  bool powered = false;
  bool moving = false;           // the profile has not ended
  bool arrived = false;          // the demand rests on the target
  bool has_target = false;       // a set-point was taken since the set-points were cleared
  bool active = false;           // the active set-point is not reached yet
  bool limit_stop = false;       // a limit switch ended the motion
  bool fresh = false;            // a set-point was taken in this tick
  bool attention = true;         // something beside the motion is going on
  bool plan_due = true;          // the motion request may have changed
  bool following_error = false;  // statusword bit 13
  bool coasting = false;         // the fault allows no braking
  bool limits_enabled = false;   // 3535h
  bool homed = false;            // a homing run found home since power-up
  bool streams = false;          // 607Ah was written since the cyclic mode is in force
  bool following = false;        // the demand of this tick goes to the streamed one
  bool dc_link = true;
};

/// What only writes and plans touch.
struct DriveRegisters {
  std::array<std::int64_t, kObjectCount> values{};
  Profile profile;
  MotionRequest request;
  double gear_ratio = 1.0;          // 3576h over 3577h
  double velocity_cap = 0.0;        // 607Fh and 6080h as they were at transition 4 [UU/s]
  double set_point_velocity = 0.0;  // 6081h of the active set-point [UU/s]
  MoveTimes synchronous_times;      // of the active set-point; duration 0 = none
  MotionLimits synchronous_limits;  // that follow from them
  bool synchronous_start = false;   // the synchronous move has not been planned yet
  double index_offset = 0.0;        // of the index pulses in the motor's frame [UU]
  double index_reading = 0.0;       // of encoder 1 in the last tick of a homing run [UU]
  std::int8_t homing_method = 0;    // 6098h of the present run
  bool index_input = false;         // 5E09h as it was in the last tick
  std::array<std::uint32_t, 8> error_history{};
  std::uint8_t error_count = 0;
  std::uint32_t stop_ticks = 0;  // since the demand of a stop ended
  AxisSettings settings;
  bool memory_error = false;    // what was stored cannot be used: fault 5530h at power-up
  bool single_encoder = false;  // 6064h is encoder 1's: both readings share one frame
};

/// One axis: its state, its lane of the servo block, its status image.
struct DriveContext {
  DriveState& state;
  DriveRegisters& registers;
  ServoState& servo;
  std::size_t lane;
  AxisStatus& status;
  const TickTiming& timing;
};

/// What the bank has to do after a write.
enum class WriteEffect : std::uint8_t { none, torque_limits, gear };

/// Power-up: registers take defaults, the state machine passes transitions 0 and, when
/// `initialise`, 1. The mechanics stay as they are.
void power_up(const DriveContext& axis, bool initialise) noexcept;

/// The rules of one object for its value: those of the table, and the narrower ones of its meaning.
[[nodiscard]] AbortCode check_object_value(ObjectRow row, std::int64_t value) noexcept;

/// A write that the dictionary allows; see AxisBank::write.
AbortCode write_object(const DriveContext& axis, ObjectRow row, std::int64_t value,
                       WriteEffect& effect) noexcept;

[[nodiscard]] std::int64_t read_object(const DriveContext& axis, ObjectRow row,
                                       AbortCode& code) noexcept;

/// The silent master of 6007h.
void lose_connection(const DriveContext& axis) noexcept;

/// What a tick of one axis asks of its block.
struct TickStart {
  bool across;   // the tick crosses a segment border: `sample_across` must be called
  bool general;  // the position loop is open: the block needs the general servo step
};

/// Steps 1 and 2 of a tick: automatic transitions, mode, plan; puts the demand into the block.
TickStart begin_tick(const DriveContext& axis, DemandBlock& demand) noexcept;
void sample_across(const DriveContext& axis, DemandBlock& demand) noexcept;

/// Steps 4 and 5: demand at the end of the tick, monitors, status image.
void end_tick(const DriveContext& axis) noexcept;

/// Statusword and identification without a tick, for an axis just powered up.
void refresh_status(const DriveContext& axis) noexcept;

/// Values of registers that the tick uses in another form; after initial values were set.
void update_derived(const DriveContext& axis) noexcept;

}  // namespace vdrive
