// SPDX-License-Identifier: Apache-2.0
#include "drive/homing_search.hpp"

#include "drive/limits.hpp"
#include "drive/registers.hpp"
#include "drive/window.hpp"
#include "vdrive/assert.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// Following error [UU] from which a standing axis counts as pressing against a stop. Standstill
/// and torque alone do not prove it: an axis that starts under load has both.
constexpr double kLagAtStop = kUserUnitsPerRevolution / 64.0;

void go_on(Drive& drive, HomingStage stage) {
  drive.state().modes.homing.stage = stage;
  drive.registers().homing.turned = false;
}

/// @return whether the home switch has changed since the last tick.
bool home_switch_changes(Drive& drive, bool active) {
  HomingRun& run = drive.registers().homing;
  const bool changes = active != run.home_input;
  run.home_input = active;
  return changes;
}

/// At the start of a stage the axis may still be braking from the previous one. An edge that it
/// passes then is on the other side of the switch, or will be passed again. So edges count only
/// once both demand and axis move in the direction of the stage.
bool moves_as_commanded(Drive& drive, double direction) {
  HomingRun& run = drive.registers().homing;
  run.turned = run.turned || (direction * demand_velocity(drive) > 0.0 &&
                              direction * actual_velocity(drive) > 0.0);
  return run.turned;
}

/// The search has reached the home switch. Its closing edge is home if the method has home there
/// (`onto`) and the axis moves in the approach direction.
/// @param edge whether the switch has just closed
/// @return whether home is reached.
bool find_home_switch(Drive& drive, bool edge) {
  const HomingMethodRow& method = homing_method_of(drive);
  const bool on_the_way = homing_direction(drive) == method.approach;
  if (method.onto && on_the_way && edge) return true;
  go_on(drive, method.onto ? HomingStage::clear : HomingStage::approach);
  return false;
}

/// A limit switch ends the search or reverses it.
void reach_limit_switch(Drive& drive) {
  const bool searches = drive.state().modes.homing.stage == HomingStage::seek;
  const bool turns = searches && homing_method_of(drive).turns;
  go_on(drive, turns ? HomingStage::seek_back : HomingStage::failed);
}

/// The axis stands from the first tick at or below 606Fh until it has moved farther than 606Fh
/// times 5E18h:02. After the first tick the velocity does not count: as the difference of two
/// readings it is too sensitive to noise.
/// @return whether the axis stands.
bool is_stationary(const Drive& drive) {
  constexpr double kSecondsAMillisecond = 1.0e-3;
  const HomingRun& run = drive.registers().homing;
  const auto threshold = static_cast<double>(drive.state().window.threshold);
  if (run.pressing == 0) return std::abs(actual_velocity(drive)) <= threshold;
  const double way = threshold * real(drive, "homing_stop_time"_object) * kSecondsAMillisecond;
  return std::abs(actual_position(drive) - run.pressed_at) <= way;
}

/// @return whether the axis pushes against something in `direction`.
bool presses_on_stop(const Drive& drive, double direction) {
  const std::size_t l = drive.lane();
  const double torque = drive.servo().torque[l] * drive.block().units.torque_per_mille[l];
  // The torque limit may be below the threshold, and the torque only approaches that limit: compare
  // the rounded torque, as 6077h shows it.
  const double wanted =
      within_torque_limits(drive, direction * real(drive, "homing_stop_torque"_object));
  const double lag = demand_position(drive) - actual_position(drive);
  return direction * lag >= kLagAtStop && direction * torque >= direction * wanted - 0.5 &&
         is_stationary(drive);
}

}  // namespace

const HomingMethodRow& homing_method_of(const Drive& drive) {
  const HomingMethodRow* const method = find_homing_method(drive.state().modes.homing.method);
  ensure(method != nullptr, "a homing run that travels has a method");
  return *method;
}

double homing_direction(const Drive& drive) {
  switch (drive.state().modes.homing.stage) {
    case HomingStage::search:
    case HomingStage::seek:
    case HomingStage::push:
    case HomingStage::press:
      return homing_method_of(drive).direction;
    case HomingStage::seek_back:
      return -homing_method_of(drive).direction;
    case HomingStage::clear:
      return -homing_method_of(drive).approach;
    case HomingStage::leave:
    case HomingStage::approach:
    case HomingStage::index:
      return homing_method_of(drive).approach;
    default:
      return 0.0;
  }
}

bool searches_at_speed(HomingStage stage) {
  return stage == HomingStage::search || stage == HomingStage::seek ||
         stage == HomingStage::seek_back || stage == HomingStage::clear ||
         stage == HomingStage::push;
}

HomingStage first_homing_stage(const Drive& drive, const HomingMethodRow& method) {
  switch (method.mark) {
    case HomingMark::limit_switch:
      return at_limit_switch(drive, method.direction) ? HomingStage::leave : HomingStage::search;
    case HomingMark::home_switch:
      if ((drive.state().limits.inputs & kHomeInput) != 0) {
        return method.onto ? HomingStage::clear : HomingStage::approach;
      }
      return method.turns && at_limit_switch(drive, method.direction) ? HomingStage::seek_back
                                                                      : HomingStage::seek;
    case HomingMark::hard_stop:
      return HomingStage::push;
    case HomingMark::none:
      break;
  }
  return HomingStage::index;
}

void begin_homing_search(Drive& drive) {
  drive.registers().homing = {.home_input = (drive.state().limits.inputs & kHomeInput) != 0};
}

bool leaves_limit_switch(Drive& drive) {
  const double direction = homing_direction(drive);
  if (at_limit_switch(drive, direction)) {
    go_on(drive, HomingStage::failed);
    return false;
  }
  return !at_limit_switch(drive, -direction) && direction * demand_velocity(drive) > 0.0;
}

bool passes_home_switch(Drive& drive) {
  const bool active = (drive.state().limits.inputs & kHomeInput) != 0;
  const double direction = homing_direction(drive);
  const bool edge = home_switch_changes(drive, active);
  const bool counts = moves_as_commanded(drive, direction);
  switch (drive.state().modes.homing.stage) {
    case HomingStage::seek:
    case HomingStage::seek_back:
      if (active && counts) return find_home_switch(drive, edge);
      break;
    case HomingStage::clear:
      if (edge && counts && !active) {
        go_on(drive, HomingStage::approach);
        return false;
      }
      break;
    default:
      if (edge && counts && active == homing_method_of(drive).onto) return true;
      break;
  }
  if (at_limit_switch(drive, direction)) reach_limit_switch(drive);
  return false;
}

bool meets_hard_stop(Drive& drive) {
  const double direction = homing_direction(drive);
  if (at_limit_switch(drive, direction)) {
    go_on(drive, HomingStage::failed);
    return false;
  }
  const bool presses = presses_on_stop(drive, direction);
  HomingRun& run = drive.registers().homing;
  if (run.pressing == 0) run.pressed_at = actual_position(drive);
  count_ticks(presses, run.pressing);
  drive.state().modes.homing.stage = presses ? HomingStage::press : HomingStage::push;
  // The first tick starts the time: n ticks have passed at tick n + 1.
  return run.pressing > ticks_of_ms(drive, reg(drive, "homing_stop_time"_object));
}

}  // namespace vdrive
