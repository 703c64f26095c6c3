// SPDX-License-Identifier: Apache-2.0
#include "drive/tick.hpp"

#include "drive/block.hpp"
#include "drive/controlword.hpp"
#include "drive/demand.hpp"
#include "drive/frame.hpp"
#include "drive/limits.hpp"
#include "drive/mode_table.hpp"
#include "drive/modulo.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"
#include "drive/window.hpp"
#include "rounding.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cmath>
#include <limits>

namespace vdrive {
namespace {

/// @return whether anything besides the motion needs the step `follow` in the next tick.
bool needs_attention(const Drive& drive, const Mode& mode) {
  const DriveState& s = drive.state();
  const PowerState state = s.power.machine.state();
  return state == PowerState::not_ready_to_switch_on || state == PowerState::quick_stop_active ||
         state == PowerState::fault_reaction_active ||
         s.power.machine.pending() != PowerCommand::none || s.faults.causes != 0 ||
         s.faults.load_level == LoadLevel::fault ||
         (s.limits.inputs & (kNegativeLimitInput | kPositiveLimitInput)) != 0 || s.limits.placed ||
         s.mode.wanted != s.mode.actual || s.power.waits ||
         (mode.evolves != nullptr && mode.evolves(drive));
}

/// Takes multiples of the register range out of a position that has become large, which invalidates
/// the plan.
void keep_frame(Drive& drive) {
  if (std::abs(demand_position(drive)) > kFrame) {
    rebase(drive);
    drive.registers().request = {};
    drive.state().plan_due = true;
  }
}

void follow(Drive& drive) {
  if (drive.state().power.waits) begin_held_back(drive);
  complete_power_up(drive);
  complete_stops(drive);
  watch_causes(drive);
  follow_mode(drive);
  if (const Mode& mode = mode_of(drive); mode.advance != nullptr) mode.advance(drive);
  if (drive.state().power.waits) end_held_back(drive);
  drive.state().plan_due = true;
}

/// Checks the following error 60F4h against 6065h and 6066h.
void watch_following_error(Drive& drive) {
  const double error = nearest(demand_position(drive)) - nearest(actual_position(drive));
  DriveState& s = drive.state();
  const PowerState state = s.power.machine.state();
  const bool watched =
      s.power.on && s.demand.control == ControlLoop::position &&
      s.following_error.window != kWindowOff &&
      (state == PowerState::operation_enabled || state == PowerState::quick_stop_active);
  const bool outside = watched && std::abs(error) > static_cast<double>(s.following_error.window);
  if (!outside) {
    s.following_error.count = 0;
    if (s.following_error.shown && !drive.registers().settings.following_error_is_fault) {
      s.following_error.shown = false;
    }
    return;
  }
  if (s.following_error.count != kSaturatedCount) ++s.following_error.count;
  // The first tick outside starts the time: more than n ticks have passed at tick n + 2.
  if (s.following_error.count <= s.following_error.ticks + 1U || s.following_error.shown) return;
  s.following_error.shown = true;
  if (drive.registers().settings.following_error_is_fault) {
    raise_fault(drive, ErrorCode::following_error);
  }
}

void watch(Drive& drive, const Mode& mode) {
  advance_demand(drive);
  watch_following_error(drive);
  if (operation_enabled(drive) && mode.watch != nullptr) mode.watch(drive);
}

/// The next set-point is taken only once the target is reached; most ticks skip this.
void take_next_set_point(Drive& drive, const Mode& mode) {
  if (drive.state().target.arrived && operation_enabled(drive) && mode.take_next != nullptr) {
    mode.take_next(drive);
  }
}

/// @return bits 10 to 13 of 6041h as set by the active mode.
std::uint16_t mode_bits(const Drive& drive, const Mode& mode) {
  if (operation_enabled(drive)) {
    return mode.status_bits != nullptr ? mode.status_bits(drive) : std::uint16_t{0};
  }
  const bool stops = drive.state().power.machine.state() == PowerState::quick_stop_active;
  return reached_when(stops && at_rest(drive));
}

std::uint16_t statusword(const Drive& drive, const Mode& mode) {
  const DriveState& s = drive.state();
  const PowerState state = s.power.machine.state();
  unsigned word = statusword_of(state) | s.manufacturer_bits | mode_bits(drive, mode);
  word |= limit_bits(drive, nearest(demand_position(drive)), nearest(actual_position(drive)));
  // Before transition 1 the state of the DC link is not known yet, so 6041h is 0200h.
  if (s.faults.dc_link && state != PowerState::not_ready_to_switch_on) {
    word |= Statusword::kVoltageEnabled;
  }
  if (s.following_error.shown) word |= Statusword::kFollowingError;
  if (s.faults.load_level != LoadLevel::rated) word |= Statusword::kWarning;
  return static_cast<std::uint16_t>(word);
}

/// Writes the status image.
void show(Drive& drive, const Mode& mode, const NumberBlock& numbers) {
  const DriveState& s = drive.state();
  AxisStatus& out = drive.status();
  show_numbers(numbers, drive.lane(), out);
  out.ds402_statusword = statusword(drive, mode);
  out.ds402_controlword = s.controlword;
  out.error_code = s.faults.error_code;
  out.error_register = s.faults.error_register;
  out.op_mode_actual = static_cast<std::int8_t>(s.mode.actual);
  out.motor_op_status = s.power.on ? 1 : 0;
  out.digital_inputs = s.limits.inputs;
  out.ignored_set_points = s.ignored_set_points;
  out.fault_count = s.faults.count;
}

/// @return whether only planned and measured values change until something is written.
bool is_undisturbed(const Drive& drive) {
  const DriveState& s = drive.state();
  return !s.attention && !s.plan_due && !s.limits.enabled && s.limits.inputs == 0;
}

/// @return whether the axis has no power, in which case an undisturbed axis is steady too.
bool is_unpowered(const Drive& drive) {
  return !drive.state().power.on && !operation_enabled(drive);
}

/// @return whether profile position mode has nothing to do while the following error stays within
///         its window.
bool holds_position(const Drive& drive, const Mode& mode) {
  const DriveState& s = drive.state();
  return mode.moves_steadily && operation_enabled(drive) && s.power.on && !s.demand.following &&
         s.demand.control == ControlLoop::position && s.following_error.count == 0 &&
         !s.following_error.shown;
}

/// @return whether the motion continues until it leaves its segment or the axis leaves a window.
bool moves_on(const Drive& drive) {
  const DriveState& s = drive.state();
  return s.demand.moving && !s.target.arrived && s.window.dwell == 0;
}

/// @return whether the axis stands on its target until it leaves the target window. No set-point
///         can be waiting: it is taken in the tick in which the target is reached.
bool stands(const Drive& drive) {
  const DriveState& s = drive.state();
  const DemandBlock& demand = drive.block().demand;
  const std::size_t l = drive.lane();
  return !s.demand.moving && !halted(drive) && on_target(drive) && s.window.dwell != 0 &&
         demand.position[l] == demand.segment_position[l];
}

double window_of(std::uint32_t window) {
  return window == kWindowOff ? std::numeric_limits<double>::infinity() : window;
}

/// Records whether the next ticks are steady, and the conditions under which that ends.
void note_steadiness(Drive& drive, const Mode& mode) {
  SteadyBlock& steady = drive.block().steady;
  const std::size_t l = drive.lane();
  const std::uint64_t bit = std::uint64_t{1} << l;
  const bool unpowered = is_unpowered(drive);
  const bool standing = !unpowered && stands(drive);
  if (!is_undisturbed(drive) ||
      !(unpowered || (holds_position(drive, mode) && (standing || moves_on(drive))))) {
    return;
  }
  steady.lanes |= bit;
  if (unpowered) steady.unpowered |= bit;
  if (standing) {
    steady.standing |= bit;
    drive.demand().plan_ticks[l] = 0.0;
  }
  steady.following_error_window[l] = window_of(drive.state().following_error.window);
  steady.target_window[l] = window_of(drive.state().window.position);
  steady.target[l] = drive.state().target.position;
}

}  // namespace

void begin_tick(Drive& drive) noexcept {
  DriveState& s = drive.state();
  keep_frame(drive);
  if (s.attention) follow(drive);
  if (s.plan_due) {
    s.plan_due = false;
    plan(drive, requested_motion(drive));
  }
}

void watch_tick(Drive& drive) noexcept {
  if (LimitState& limits = drive.state().limits; limits.placed) {
    limits.inputs = active_inputs(drive);
  }
  const Mode& mode = mode_of(drive);
  watch(drive, mode);
  take_next_set_point(drive, mode);
}

void freeze_feedback(const Drive& drive, NumberBlock& numbers) noexcept {
  const std::size_t l = drive.lane();
  const AxisStatus& shown = drive.status();
  const double demand = numbers.position_demand_value[l];
  const double load = shown.load_position_actual_value;
  const double motor = shown.motor_position_actual_value;
  const bool is_one_frame = drive.registers().single_encoder;
  numbers.load_position_actual_value[l] = shown.load_position_actual_value;
  numbers.load_position_error_value[l] = wrapped(shorter_way(drive, demand - load));
  numbers.motor_position_actual_value[l] = shown.motor_position_actual_value;
  numbers.motor_position_error_value[l] =
      wrapped(is_one_frame ? shorter_way(drive, demand - motor) : demand - motor);
  numbers.load_velocity_actual_value[l] = 0;
  numbers.load_velocity_error_value[l] = numbers.velocity_demand_value[l];
  numbers.motor_velocity_actual_value[l] = 0;
  numbers.motor_velocity_error_value[l] = numbers.velocity_demand_value[l];
}

void end_tick(Drive& drive, const NumberBlock& numbers) noexcept {
  DriveState& s = drive.state();
  const Mode& mode = mode_of(drive);
  show(drive, mode, numbers);
  if (s.power.ticks_in_state != kSaturatedCount) ++s.power.ticks_in_state;
  s.attention = needs_attention(drive, mode);
  note_steadiness(drive, mode);
  s.target.fresh = false;
}

void end_steadiness(Drive& drive) noexcept {
  BlockState& block = drive.block();
  const std::size_t l = drive.lane();
  const std::uint64_t bit = std::uint64_t{1} << l;
  if ((block.steady.standing & bit) != 0) {
    std::uint32_t& dwell = drive.state().window.dwell;
    const double ticks = dwell + block.demand.plan_ticks[l];
    dwell = ticks < kSaturatedCount ? static_cast<std::uint32_t>(ticks) : kSaturatedCount;
    block.demand.plan_ticks[l] = 0.0;
  }
  block.steady.lanes &= ~bit;
  block.steady.standing &= ~bit;
  block.steady.unpowered &= ~bit;
}

void show(Drive& drive) noexcept {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init): filled by the next statement
  NumberBlock numbers;
  round_numbers(drive.block(), numbers);
  if (is_modulo(drive)) fold_numbers(drive, numbers);
  if (shows_frozen_feedback(drive)) freeze_feedback(drive, numbers);
  show(drive, mode_of(drive), numbers);
}

}  // namespace vdrive
