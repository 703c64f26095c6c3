// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/homing.hpp"

#include "drive/frame.hpp"
#include "drive/habits.hpp"
#include "drive/homing_search.hpp"
#include "drive/limits.hpp"
#include "drive/stops.hpp"
#include "drive/window.hpp"
#include "vdrive/cia402/homing_method.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// @return whether a run is in progress, including the way back to home.
bool runs(HomingStage stage) {
  return stage != HomingStage::idle && stage != HomingStage::done && stage != HomingStage::failed;
}

/// Finds the first index pulse passed in `direction` since the reading `before`.
/// @return whether there was one; `place` is its position in the frame of the motor [UU].
bool passed_index(const Drive& drive, double direction, double before, double& place) {
  const auto pulse =
      index_pulse_passed(drive, direction, before, drive.servo().motor_reading[drive.lane()]);
  if (pulse) place = *pulse;
  return pulse.has_value();
}

/// Makes `home` [UU] position 607Ch: the frame of all positions moves, the mechanics do not.
void attain(Drive& drive, double home) {
  DriveState& s = drive.state();
  DriveRegisters& r = drive.registers();
  const double offset = real(drive, "home_offset"_object);
  const double shift = home - offset;
  shift_frame(drive, {.motor = shift, .load = shift, .reading = shift});
  r.request = {};  // the plan was made in the old frame
  s.target.position = offset;
  s.target.arrived = false;
  s.modes.homing.stage = HomingStage::back;
  s.limits.homed = true;
  update_derived(drive);
}

void attain_at_index(Drive& drive, double place) {
  const double ratio = drive.registers().single_encoder ? 1.0 : drive.registers().gear_ratio;
  const std::size_t l = drive.lane();
  attain(drive, drive.servo().load_reading[l] + ratio * (place - drive.servo().motor_reading[l]));
}

void seek_index(Drive& drive, double before, bool index_input_rose) {
  const double direction = homing_direction(drive);
  double place = 0.0;
  if (passed_index(drive, direction, before, place)) {
    attain_at_index(drive, place);
  } else if (index_input_rose) {
    attain(drive, actual_position(drive));
  } else if (at_limit_switch(drive, direction)) {
    drive.state().modes.homing.stage = HomingStage::failed;
  }
}

/// The axis has passed the switch or stop of the method. Home is there or at the next index pulse.
void pass_mark(Drive& drive) {
  if (homing_method_of(drive).index) {
    drive.state().modes.homing.stage = HomingStage::index;
  } else {
    attain(drive, actual_position(drive));
  }
}

/// Rising edge of bit 4: starts a run by 6098h.
/// @return false when a run is already in progress; the edge is then ignored.
bool start(Drive& drive) {
  DriveState& s = drive.state();
  DriveRegisters& r = drive.registers();
  if (runs(s.modes.homing.stage)) return false;
  s.limits.homed = false;
  s.window.dwell = 0;
  s.target.arrived = false;
  s.modes.homing.method = static_cast<std::int8_t>(reg(drive, "homing_method"_object));
  r.index.input = reg(drive, "test_index_pulse_input"_object) != 0;
  r.index.reading = drive.servo().motor_reading[drive.lane()];
  begin_homing_search(drive);
  const HomingMethodRow* const method = find_homing_method(s.modes.homing.method);
  const bool has_speeds =
      reg(drive, "homing_speed_search"_object) != 0 && reg(drive, "homing_speed_creep"_object) != 0;
  if (method == nullptr || (method->direction != 0 && !has_speeds)) {
    s.modes.homing.stage = HomingStage::failed;
  } else if (method->direction == 0) {
    s.modes.homing.stage = HomingStage::present;
  } else {
    s.modes.homing.stage = first_homing_stage(drive, *method);
  }
  update_derived(drive);
  return true;
}

/// Ends a run in progress; the result of an earlier run stays.
void interrupt(Drive& drive) {
  DriveState& s = drive.state();
  if (runs(s.modes.homing.stage)) {
    s.modes.homing.stage = HomingStage::idle;
    s.plan_due = true;
  }
}

/// Halt has ended. Its stop has made the position of rest the target, but the target of the way
/// back is home.
void continue_run(Drive& drive) {
  DriveState& s = drive.state();
  if (s.modes.homing.stage != HomingStage::back) return;
  s.target.position = real(drive, "home_offset"_object);
  s.target.arrived = false;
}

/// Bit 4 starts a homing run. Bit 8 stops it; the run continues if bit 8 returns to 0 while bit 4
/// is still 1.
void command(Drive& drive, const WrittenControlword& word) {
  DriveState& s = drive.state();
  const bool wanted = (s.controlword & Controlword::kStartHoming) != 0;
  const bool falling = !wanted && (word.previous & Controlword::kStartHoming) != 0;
  const bool released = !halted(drive) && (word.previous & Controlword::kHalt) != 0;
  const bool ended_by_halt =
      ends_homing_at_halt(drive) ? halted(drive) : (halted(drive) || released) && !wanted;
  if (ended_by_halt || (falling && homes_by_level(drive))) interrupt(drive);
  if (released) continue_run(drive);
  const bool rising = wanted && (word.previous & Controlword::kStartHoming) == 0;
  if (!rising) return;
  if (word.accepting && !halted(drive) && start(drive)) {
    s.target.fresh = true;
  } else {
    ++s.ignored_set_points;
  }
}

/// Home is the position where the axis rests.
void take_present_position(Drive& drive) {
  if (drive.state().demand.moving) return;
  attain(drive, demand_position(drive));
  rest_at(drive, drive.state().target.position);  // 6099h may be 0: leave no distance to travel
}

/// One tick of a run in progress.
/// @param before reading of encoder 1 in the previous tick [UU]
/// @param index_input_rose whether 5E09h has become 1
void follow_stage(Drive& drive, double before, bool index_input_rose) {
  HomingState& homing = drive.state().modes.homing;
  switch (homing.stage) {
    case HomingStage::present:
      take_present_position(drive);
      break;
    case HomingStage::search:
      if (at_limit_switch(drive, homing_direction(drive))) homing.stage = HomingStage::leave;
      break;
    case HomingStage::leave:
      if (leaves_limit_switch(drive)) pass_mark(drive);
      break;
    case HomingStage::seek:
    case HomingStage::seek_back:
    case HomingStage::clear:
    case HomingStage::approach:
      if (passes_home_switch(drive)) pass_mark(drive);
      break;
    case HomingStage::push:
    case HomingStage::press:
      if (meets_hard_stop(drive)) pass_mark(drive);
      break;
    case HomingStage::index:
      seek_index(drive, before, index_input_rose);
      break;
    default:
      break;
  }
}

/// Evaluates switches, index pulse, torque and position of the last tick, and may go on to the next
/// stage.
void advance(Drive& drive) {
  DriveState& s = drive.state();
  if (s.target.fresh || !runs(s.modes.homing.stage)) {
    return;  // the status must show the start before anything is found
  }
  if (s.power.machine.pending() != PowerCommand::none) {
    interrupt(drive);
    return;
  }
  DriveRegisters& r = drive.registers();
  const bool index_input = reg(drive, "test_index_pulse_input"_object) != 0;
  const bool rose = index_input && !r.index.input;
  const double before = r.index.reading;
  r.index.input = index_input;
  r.index.reading = drive.servo().motor_reading[drive.lane()];
  follow_stage(drive, before, rose);
}

MotionRequest normal_stop(const Drive& drive) {
  return ramp_stop(drive, "homing_acceleration"_object);
}

/// Searches at the speeds of 6099h with the acceleration 609Ah; the way back to home is a move to a
/// target.
MotionRequest travel(const Drive& drive) {
  const bool searches = searches_at_speed(drive.state().modes.homing.stage);
  const double speed =
      std::min(real(drive, searches ? "homing_speed_search"_object : "homing_speed_creep"_object),
               drive.registers().velocity_cap);
  return {.kind = MotionRequest::Kind::velocity,
          .target = homing_direction(drive) * speed,
          .limits = {.velocity = speed,
                     .acceleration = acceleration_of(drive, "homing_acceleration"_object),
                     .deceleration = deceleration_of(drive, "homing_acceleration"_object)}};
}

MotionRequest ask(const Drive& drive) {
  if (halted(drive)) {
    return stop_by_option(drive, reg(drive, "halt_option_code"_object), normal_stop(drive));
  }
  switch (drive.state().modes.homing.stage) {
    case HomingStage::search:
    case HomingStage::leave:
    case HomingStage::seek:
    case HomingStage::seek_back:
    case HomingStage::clear:
    case HomingStage::approach:
    case HomingStage::push:
    case HomingStage::index:
      return travel(drive);
    case HomingStage::back:
    case HomingStage::done: {
      MotionRequest request = travel(drive);
      request.kind = MotionRequest::Kind::move;
      request.target = drive.state().target.position;
      return request;
    }
    default:
      return normal_stop(drive);
  }
}

/// The run ends when the axis has come back to home.
void watch(Drive& drive) {
  HomingState& homing = drive.state().modes.homing;
  if (halted(drive) && runs(homing.stage)) return;
  if (homing.stage == HomingStage::back || homing.stage == HomingStage::done) {
    watch_target_window(drive);
    if (on_target(drive)) homing.stage = HomingStage::done;
  }
}

/// Bits 10, 12 and 13. Under halt a run is shown as interrupted, even on its way back: the axis has
/// not reached home.
std::uint16_t status_bits(const Drive& drive) {
  const HomingStage stage = drive.state().modes.homing.stage;
  switch (halted(drive) && runs(stage) ? HomingStage::idle : stage) {
    case HomingStage::idle:
      // A load pushed from outside must not look like a run.
      return reached_when(!drive.state().demand.moving);
    case HomingStage::failed:
      return static_cast<std::uint16_t>(reached_when(at_rest(drive)) | Statusword::kHomingError);
    case HomingStage::back:
    case HomingStage::done:
      return static_cast<std::uint16_t>(reached_when(on_target(drive)) |
                                        Statusword::kHomingAttained);
    default:
      return 0;
  }
}

/// Readings advance a run from stage to stage.
bool evolves(const Drive& drive) {
  return runs(drive.state().modes.homing.stage);
}

}  // namespace

constinit const Mode kHoming{.normal_ramp = "homing_acceleration"_object,
                             .command = command,
                             .advance = advance,
                             .ask = ask,
                             .watch = watch,
                             .status_bits = status_bits,
                             .evolves = evolves};

}  // namespace vdrive
