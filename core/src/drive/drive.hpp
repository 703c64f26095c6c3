// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plant/servo_block.hpp"
#include "vdrive/axis_configuration.hpp"
#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/power_state_machine.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/motion/profile.hpp"
#include "vdrive/motion/set_point_queue.hpp"

#include <array>
#include <cstdint>

namespace vdrive {

/// Operating modes 6060h/6061h that work.
inline constexpr std::int8_t kNoMode = 0;
inline constexpr std::int8_t kProfilePosition = 1;

/// Ticks of a bank, as the drive needs them.
struct TickTiming {
  std::uint32_t period_us = 1000;
  std::uint32_t substeps = 8;
  double substep = 125.0e-6;  // [s]
};

/// What the demand generator is asked for. Two equal requests need no new plan.
struct MotionRequest {
  enum class Kind : std::uint8_t { hold, stop, move };

  Kind kind = Kind::hold;
  double target = 0.0;  // move [UU]
  MotionLimits limits;  // move; stop uses the deceleration

  friend bool operator==(const MotionRequest& a, const MotionRequest& b) noexcept {
    return a.kind == b.kind && a.target == b.target && a.limits.velocity == b.limits.velocity &&
           a.limits.acceleration == b.limits.acceleration &&
           a.limits.deceleration == b.limits.deceleration;
  }
};

/// What every tick touches of an axis.
struct DriveState {
  Segment segment;                       // of the profile, now; a resting one between motions
  double plan_ticks = 0.0;               // since the plan
  double demand_position = 0.0;          // [UU]
  double demand_velocity = 0.0;          // [UU/s]
  double target = 0.0;                   // latched internal target, whole [UU]
  double torque_per_mille = 0.0;         // 6077h of one torque unit
  double current_per_mille = 0.0;        // 6078h of one torque unit
  double rated_current = 0.0;            // [mA]
  double lower_limit = 0.0;              // 607Dh:01 [UU]
  double upper_limit = 0.0;              // 607Dh:02 [UU]
  std::uint32_t window = 0;              // 6067h [UU]
  std::uint32_t window_ticks = 0;        // 6068h
  std::uint32_t dwell = 0;               // ticks inside the window, the present one included
  std::uint32_t following_window = 0;    // 6065h [UU]
  std::uint32_t following_ticks = 0;     // 6066h
  std::uint32_t following_count = 0;     // ticks outside the window
  std::uint32_t velocity_threshold = 0;  // 606Fh [UU/s]
  std::uint32_t ticks_in_state = 0;
  std::uint32_t ignored_set_points = 0;
  std::uint32_t fault_count = 0;
  std::uint16_t controlword = 0;
  std::uint16_t error_code = 0;
  std::int8_t mode = kNoMode;         // 6061h
  std::int8_t wanted_mode = kNoMode;  // 6060h
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
  std::array<std::uint32_t, 8> error_history{};
  std::uint8_t error_count = 0;
  std::uint32_t stop_ticks = 0;  // since the demand of a stop ended
  AxisSettings settings;
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

/// A write that the dictionary allows; see AxisBank::write.
AbortCode write_object(const DriveContext& axis, ObjectRow row, std::int64_t value,
                       WriteEffect& effect) noexcept;

[[nodiscard]] std::int64_t read_object(const DriveContext& axis, ObjectRow row,
                                       AbortCode& code) noexcept;

/// The silent master of 6007h.
void lose_connection(const DriveContext& axis) noexcept;

/// Steps 1 and 2 of a tick: automatic transitions, mode, plan; puts the demand into the block.
/// @return true when the tick crosses a segment border: `sample_across` must then be called.
bool begin_tick(const DriveContext& axis, DemandBlock& demand) noexcept;
void sample_across(const DriveContext& axis, DemandBlock& demand) noexcept;

/// Steps 4 and 5: demand at the end of the tick, monitors, status image.
void end_tick(const DriveContext& axis) noexcept;

/// Statusword and identification without a tick, for an axis just powered up.
void refresh_status(const DriveContext& axis) noexcept;

/// Values of registers that the tick uses in another form; after initial values were set.
void update_derived(const DriveContext& axis) noexcept;

}  // namespace vdrive
