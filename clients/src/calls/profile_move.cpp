// SPDX-License-Identifier: Apache-2.0
#include "calls/profile_move.hpp"

#include "base/drive_words.hpp"
#include "calls/arrival.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/plant/axis_model.hpp"
#include "vdrive/quantity.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::client {
namespace {

using namespace literals;

/// In the order of kMoveObjects.
enum MoveObject : std::size_t {
  velocity,
  acceleration,
  deceleration,
  highest_speed,
  motor_limit = kMoveBounds.size(),
  relative_base,
  controlword_loop
};

/// 60F2h bits 0 and 1: a relative target counts from the actual position.
constexpr std::int64_t kFromActualPosition = 2;

void add_members(msg::AxisCommand& command, std::uint16_t members) {
  command.members = static_cast<std::uint16_t>(command.members | members);
}

}  // namespace

Outcome check_bounds(const AxisId& axis, std::span<const std::int64_t> values) {
  const auto zero = std::ranges::find(values, 0);
  if (zero == values.end()) return {};
  const auto place = static_cast<std::size_t>(zero - values.begin());
  return not_in_this_state("axis " + to_string(axis) + ": " + object_text(kMoveBounds.at(place)) +
                           " is 0: the axis cannot move");
}

Outcome above_limit(const AxisId& axis, const Unit& unit, std::string_view what, std::int64_t value,
                    ObjectRow limit, std::int64_t limit_value, std::string_view remark) {
  return not_in_this_state("axis " + to_string(axis) + ": the " + std::string(what) + " " +
                           object_value_text(limit, value, unit) + " is above " +
                           object_text(vdrive::describe(limit).address) + " = " +
                           object_value_text(limit, limit_value, unit) + std::string(remark));
}

Outcome check_speed(const AxisId& axis, const Unit& unit, std::int64_t velocity,
                    const SpeedLimits& limits, std::string_view what) {
  const std::int64_t speed = std::abs(velocity);
  if (speed > limits.app_speed_limit) {
    return above_limit(axis, unit, what, velocity, "app_speed_limit"_object,
                       limits.app_speed_limit);
  }
  if (speed > limits.motor_speed_limit) {
    return above_limit(axis, unit, what, velocity, "motor_speed_limit"_object,
                       limits.motor_speed_limit,
                       ", which follows from motor_max_speed_rpm (6080h) and the gear");
  }
  return {};
}

Outcome ProfileMove::prepare() {
  auto values = call_.take_values();
  if (!values) return values.outcome();
  before_ = std::move(values->front());
  has_controlword_loop_ = before_[controlword_loop] != 0;
  std::vector<std::int64_t> in_force = before_;
  in_force.resize(kMoveBounds.size());
  in_force[velocity] = options_.velocity.value_or(before_[velocity]);
  in_force[acceleration] = options_.acceleration.value_or(before_[acceleration]);
  in_force[deceleration] = options_.deceleration.value_or(before_[deceleration]);
  const AxisId& axis = call_.snapshot().id;
  if (Outcome good = check_bounds(axis, in_force); !good || !options_.velocity) return good;
  // The drive silently limits 6081h to 607Fh; a value given to the call must not be limited.
  return check_speed(
      axis, call_.unit_of(axis), *options_.velocity,
      {.app_speed_limit = before_[highest_speed], .motor_speed_limit = before_[motor_limit]});
}

/// The set-point with the rising edge of bit 4.
Round ProfileMove::set_point(std::int32_t target, bool relative) const {
  std::uint16_t word = kEnableOperation | Controlword::kNewSetPoint;
  if (!options_.queue) word |= Controlword::kChangeSetImmediately;
  if (relative) word |= Controlword::kRelative;
  Round round = call_.round_of(word, every_axis);
  msg::AxisCommand& command = round.entries.front().command;
  add_members(command, msg::HAS_POSITION_USER_TARGET_VALUE);
  command.position_user_target_value = target;
  if (options_.velocity) {
    add_members(command, msg::HAS_PROFILE_VELOCITY);
    command.profile_velocity = *options_.velocity;
  }
  if (options_.acceleration) {
    add_members(command, msg::HAS_PROFILE_ACC);
    command.profile_acc = *options_.acceleration;
  }
  if (options_.deceleration) {
    add_members(command, msg::HAS_PROFILE_DEC);
    command.profile_dec = *options_.deceleration;
  }
  return round;
}

/// A relative target counts from the actual position if 60F2h selects that; otherwise from the
/// demand position, which is exact for an axis at rest.
std::int32_t ProfileMove::target_of(std::int32_t value, bool relative) const {
  if (!relative) return value;
  const AxisStatus& status = call_.snapshot().status;
  const std::int32_t base = before_[relative_base] == kFromActualPosition
                                ? status.load_position_actual_value
                                : status.position_demand_value;
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(base) +
                                   static_cast<std::uint32_t>(value));
}

Outcome ProfileMove::start(std::int32_t target, bool relative) {
  target_ = target_of(target, relative);
  const bool leads_up = target_ > call_.snapshot().status.position_demand_value;
  wraps_ = relative && target != 0 && leads_up != (target > 0);
  is_relative_ = relative;
  // Bit 4 must be 0 before its edge: another thread may have just set it.
  std::vector<Round> rounds{call_.round_of(kEnableOperation, every_axis),
                            set_point(target, relative)};
  // The drive samples 6081h when it sees the edge, in most cases in the tick of the edge.
  const bool keeps_velocity = options_.velocity && has_controlword_loop_;
  if (options_.velocity && !keeps_velocity) rounds.push_back(old_velocity());
  if (Outcome done = call_.put_in_force(rounds); !done) {
    if (done.kind() == OutcomeKind::refused) put_back_ramps();
    return done;
  }
  // From here on, bits 12 and 10 belong to this set-point, which acts in the observed tick.
  Outcome taken = await_acknowledge();
  if (!keeps_velocity) return taken;
  const Round velocity_back = old_velocity();
  Outcome back = call_.put_in_force({&velocity_back, 1});
  return taken ? back : taken;
}

/// A drive that evaluates every controlword has already answered that it took the set-point. Bit 12
/// may be 0 again if another thread has cleared bit 4 after its own move.
Outcome ProfileMove::await_acknowledge() {
  constexpr std::string_view kAcknowledge = "the acknowledgement, bit 12";
  if (!has_controlword_loop_) return call_.check(kAcknowledge, call_.tick());
  return call_.await_enabled(kAcknowledge, call_.tick(), [](const AxisSnapshot& axis) {
    return axis.shows(Statusword::kSetPointAcknowledge);
  });
}

/// @return a round that restores 6081h, which was set for this move only.
Round ProfileMove::old_velocity() const {
  Round round = call_.round_to(every_axis);
  msg::AxisCommand& command = round.entries.front().command;
  add_members(command, msg::HAS_PROFILE_VELOCITY);
  command.profile_velocity = static_cast<std::uint32_t>(before_[velocity]);
  return round;
}

Outcome ProfileMove::await_target() {
  Outcome reached = client::await_target(
      call_, wakeup_, wraps_ ? std::nullopt : std::optional(target_), call_.tick());
  if (reached) return reached;
  if (call_.is_superseded()) return reached;  // the ramps belong to another motion
  // After a time-out the axis is still moving, and after a halt it may continue: keep the ramps of
  // its motion.
  const AxisSnapshot& axis = call_.snapshot();
  const bool is_over = axis.status.velocity_demand_value == 0 && !target_reached(axis);
  if (!is_enabled(axis) || is_over) put_back_ramps();
  return reached;
}

/// @return whether there are ramps to restore.
bool ProfileMove::add_old_ramps(Round& round) const {
  msg::AxisCommand& command = round.entries.front().command;
  if (options_.acceleration) {
    add_members(command, msg::HAS_PROFILE_ACC);
    command.profile_acc = static_cast<std::uint32_t>(before_[acceleration]);
  }
  if (options_.deceleration) {
    add_members(command, msg::HAS_PROFILE_DEC);
    command.profile_dec = static_cast<std::uint32_t>(before_[deceleration]);
  }
  return options_.acceleration || options_.deceleration;
}

/// Called after a failure, which stays the outcome whether or not this succeeds.
void ProfileMove::put_back_ramps() {
  Round round = call_.round_to(every_axis);
  if (add_old_ramps(round)) (void)call_.put_in_force({&round, 1});
}

Outcome ProfileMove::finish() {
  const AxisSnapshot at_rest = call_.snapshot();
  Round last = call_.round_of(kEnableOperation, every_axis);
  const bool waited = options_.call.until == Until::done;
  if (waited) add_old_ramps(last);
  if (Outcome done = call_.put_in_force({&last, 1}); !done) return done;
  if (Outcome free = await_next_edge(); !free) return free;
  // The target of a relative move is unknown if 60F2h counts from an earlier target.
  return waited ? check_arrival(call_, at_rest, target_, !is_relative_) : Outcome();
}

/// A drive that evaluates its controlword once per loop has seen bit 4 go low when bit 12 goes low:
/// another edge before that would be lost.
Outcome ProfileMove::await_next_edge() {
  // Bit 12 of a queued set-point stays 1 until the buffer is free.
  if (options_.queue || !has_controlword_loop_) return {};
  return call_.await("the end of the acknowledgement, bit 12", call_.tick(),
                     [](const AxisSnapshot& axis) {
                       return !is_enabled(axis) || axis.mode() != OperatingMode::profile_position ||
                              !axis.shows(Statusword::kSetPointAcknowledge);
                     });
}

}  // namespace vdrive::client
