// SPDX-License-Identifier: Apache-2.0
// The calls of an axis for the modes homing, profile velocity and profile torque.
#include "base/drive_words.hpp"
#include "calls/arrival.hpp"
#include "calls/axes_command.hpp"
#include "calls/profile_move.hpp"
#include "calls/slow_drive.hpp"
#include "session/session_core.hpp"
#include "vdrive/cia402/standing_targets.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace literals;

/// Longer than anybody holds a button.
constexpr std::chrono::hours kHeldAtMost{24 * 365};

/// An object that a call sets, if a value was given.
struct Setting {
  ObjectRow row = 0;
  std::optional<std::int64_t> value{};
};

/// Connects, takes control and checks that the axis can move.
/// @param objects that the call reads first: AxesCall::take_values()
Outcome begin_motion(AxesCall& call, std::chrono::nanoseconds timeout, std::string_view what,
                     std::span<const ObjectAddress> objects) {
  if (Outcome ready = call.begin_control(timeout, objects); !ready) return ready;
  return call.require(is_enabled, what, "Operation enabled");
}

void add_settings(msg::AxisCommand& command, std::span<const Setting> settings) {
  for (const Setting& setting : settings) {
    if (!setting.value) continue;
    add_object(command, vdrive::describe(setting.row).address, *setting.value);
  }
}

/// The endless motion that a call commands. However the call ends, the session does not release the
/// axis before it has been seen at rest: see HeldAxes.
class EndlessMotion {
 public:
  EndlessMotion(SessionCore& core, const AxesCall& call)
      : held_axes_(core.held_axes),
        key_(call.axes().parts().front().target.key),
        axis_(call.snapshot().id.axis) {}

  /// Sends `round` and observes the tick in which it takes effect.
  Outcome put_in_force(AxesCall& call, Round round) {
    const bool was_running = !rests(call.snapshot()) || held_axes_.is_running(key_, axis_);
    round.is_endless = true;
    Outcome done = call.put_in_force({&round, 1});
    if (done.kind() == OutcomeKind::refused && !was_running) settle();  // it is at rest
    return done;
  }

  /// Call this when the axis was seen to stop, or the program knows that it runs on after the call.
  void settle() { held_axes_.forget_running(key_, {&axis_, 1}); }

 private:
  HeldAxes& held_axes_;
  BenchKey key_;
  std::uint16_t axis_;
};

/// Sends the mode, the settings and Enable operation in one frame, so that the axis never runs the
/// mode with older settings, and waits until 6061h shows the mode: a moving axis brakes first.
/// @param motion the motion that this starts; null for a mode whose motion ends by itself
Outcome enter(AxesCall& call, OperatingMode mode, std::span<const Setting> settings,
              EndlessMotion* motion = nullptr) {
  Round round = call.round_of(kEnableOperation, every_axis);
  msg::AxisCommand& command = round.entries.front().command;
  command.members = static_cast<std::uint16_t>(command.members | msg::HAS_OP_MODE_CMD);
  command.op_mode_cmd = static_cast<std::int8_t>(mode);
  add_settings(command, settings);
  Outcome done = motion != nullptr ? motion->put_in_force(call, std::move(round))
                                   : call.put_in_force({&round, 1});
  if (!done) return done;
  return call.await_enabled(std::string(to_string(mode)) + " mode", call.tick(),
                            [mode](const AxisSnapshot& axis) {
                              return axis.mode() == mode;
                            });
}

/// @return `seen`; if the wait was interrupted while the axis keeps moving, an outcome that says
///         so.
Outcome explained(Outcome seen, const AxesCall& call, const Wakeup& wakeup, std::string_view what) {
  const bool goes_on =
      seen.kind() == OutcomeKind::failed && is_enabled(call.snapshot()) && wakeup.is_interrupted();
  if (!goes_on) return seen;
  return Outcome::failed("interrupted; axis " + to_string(call.snapshot().id) + " continues " +
                         std::string(what));
}

/// @return `seen`; for a time-out, with the progress of the axis instead of its state.
/// @param progress a text such as "at 812 of 1000 UU/s"
Outcome with_progress(Outcome seen, const AxesCall& call, std::string_view awaited,
                      const std::string& progress) {
  if (seen.kind() != OutcomeKind::timed_out || !is_enabled(call.snapshot())) return seen;
  return Outcome::timed_out("axis " + to_string(call.snapshot().id) +
                            ": timed out while waiting for " + std::string(awaited) + ", " +
                            progress);
}

// ---- homing ----------------------------------------------------------------------------------

constexpr std::string_view kEndOfHoming = "the end of the homing run, bit 10";

bool is_homing(const AxisSnapshot& axis) {
  constexpr std::uint16_t kEnded =
      Statusword::kTargetReached | Statusword::kHomingAttained | Statusword::kHomingError;
  return axis.mode() == OperatingMode::homing && (axis.status.ds402_statusword & kEnded) == 0;
}

constexpr std::array kSpeedLimits{kObjectRows["app_speed_limit"_object].address,
                                  kObjectRows["motor_speed_limit"_object].address};

/// @return the objects that homing reads first.
std::span<const ObjectAddress> homing_objects(const HomingOptions& options) {
  if (!options.search_speed && !options.creep_speed) return {};
  return kSpeedLimits;
}

/// Checks the given speeds explicitly, because the drive limits 6099h silently.
Outcome check_homing_speeds(AxesCall& call, const HomingOptions& options) {
  if (homing_objects(options).empty()) return {};
  const auto values = call.take_values();
  if (!values) return values.outcome();
  const SpeedLimits limits{.app_speed_limit = values->front()[0],
                           .motor_speed_limit = values->front()[1]};
  const std::array speeds{Setting{"homing_speed_search"_object, options.search_speed},
                          Setting{"homing_speed_creep"_object, options.creep_speed}};
  for (const Setting& speed : speeds) {
    if (!speed.value) continue;
    const std::string what = object_text(vdrive::describe(speed.row).address);
    const AxisId& axis = call.snapshot().id;
    Outcome good = check_speed(axis, call.unit_of(axis), *speed.value, limits, what);
    if (!good) return good;
  }
  return {};
}

/// @return a text such as "at -512 UU (-45.00 deg), still moving at -1024 UU/s (-90.00 deg/s)".
std::string homing_progress(const AxesCall& call) {
  const AxisStatus& status = call.snapshot().status;
  return "at " + call.position_text(status.position_demand_value) + ", still moving at " +
         call.velocity_text(status.velocity_demand_value);
}

/// Evaluates the statusword at the end of a homing run.
Outcome homing_result(AxesCall& call) {
  const AxisSnapshot& axis = call.snapshot();
  const std::string name = "axis " + to_string(axis.id);
  if (axis.shows(Statusword::kHomingError)) {
    const std::array method{kObjectRows["homing_method"_object].address};
    const auto value = call.read(method);
    if (!value) return value.outcome();
    return Outcome::failed(name + ": homing error, bit 13, with homing_method (6098h) = " +
                           std::to_string(value->front().front()));
  }
  if (axis.shows(Statusword::kHomingAttained)) return {};
  return call.explain_by_service(
      Outcome::failed(name + ": the homing run was ended by a halt or a stop"), axis);
}

// ---- velocity --------------------------------------------------------------------------------

constexpr std::string_view kVelocityReached = "the velocity, bit 10";

bool has_velocity(const AxisSnapshot& axis) {
  return axis.mode() == OperatingMode::profile_velocity && target_reached(axis);
}

/// With limited jerk J, the first and the last unit of velocity of a ramp take √(2/J) each, and
/// twice that if the ramp starts with an acceleration in the opposite direction.
/// @param jerk [UU/s³]
/// @return the constant ramp [UU/s²] that takes this longer time for every unit.
std::int64_t even_ramp_of(std::int64_t jerk) {
  return static_cast<std::int64_t>(std::sqrt(static_cast<double>(jerk) / 8.0));
}

/// The objects that check_velocity() compares with.
constexpr auto kVelocityObjects =
    move_bounds_and<"motor_speed_limit"_object, "motion_profile_type"_object,
                    "profile_jerk_1"_object, "profile_jerk_2"_object>();

/// @param slowest receives the gentlest ramp that the drive may use [UU/s²]
/// @return refused if the drive would accept the velocity and never reach it.
Outcome check_velocity(AxesCall& call, std::int32_t velocity, const VelocityOptions& options,
                       std::int64_t& slowest) {
  auto values = call.take_values();
  if (!values) return values.outcome();
  std::vector<std::int64_t>& bounds = values->front();
  const std::vector<std::int64_t> others(bounds.begin() + kMoveBounds.size(), bounds.end());
  bounds.resize(kMoveBounds.size());
  const std::int64_t motor_speed = others[0];
  const bool has_jerk = others[1] != 0;  // 6086h
  const std::int64_t jerk = std::min(others[2], others[3]);
  bounds[0] = std::abs(std::int64_t{velocity});  // 6081h is for profile position mode
  bounds[1] = options.acceleration.value_or(bounds[1]);
  bounds[2] = options.deceleration.value_or(bounds[2]);
  slowest = std::min({bounds[1], bounds[2], bounds[4], bounds[5]});
  if (has_jerk) slowest = std::min(slowest, even_ramp_of(jerk));
  if (velocity == 0) return {};
  if (Outcome good = check_bounds(call.snapshot().id, bounds); !good) return good;
  return check_speed(call.snapshot().id, call.unit_of(call.snapshot().id), velocity,
                     {.app_speed_limit = bounds[3], .motor_speed_limit = motor_speed});
}

/// Detects a demand that no longer changes although it should follow a ramp.
class RampWatch {
 public:
  /// @param slope [units of the demand per second]; 0 counts as 1
  RampWatch(std::int64_t slope, std::chrono::microseconds period)
      : patience_(kSlack + ticks_of(longest_step(slope), period)) {}

  void note(std::uint64_t tick, std::int64_t demand) {
    if (demand == demand_ && since_ != 0) {
      rests_ = tick - since_ > patience_;
      return;
    }
    demand_ = demand;
    since_ = tick;
    rests_ = false;
  }

  [[nodiscard]] bool rests() const noexcept { return rests_; }

 private:
  /// A ramp reaches the next integer within this time; doubled for safety.
  static std::chrono::nanoseconds longest_step(std::int64_t slope) {
    return std::chrono::nanoseconds(std::chrono::seconds(2)) / std::max<std::int64_t>(slope, 1);
  }

  // Covers the tick in which the command takes effect, the first tick of the mode, and a lost
  // sample.
  static constexpr std::uint64_t kSlack = 10;

  std::uint64_t patience_;
  std::int64_t demand_ = 0;
  std::uint64_t since_ = 0;  ///< tick; 0 = nothing noted yet
  bool rests_ = false;
};

/// Obstacles seen while waiting for a velocity or a torque.
struct Obstacles {
  LimitSwitchWatch limit_switch;
  RampWatch ramp;

  /// @param target the sign is the direction
  void note(const AxisSnapshot& axis, std::int64_t target, std::int64_t demand) {
    limit_switch.note(axis, target);
    ramp.note(axis.driven_tick(), demand);
  }

  [[nodiscard]] bool keep_back(const AxisSnapshot& axis) const {
    return limit_switch.has_ended(axis) || ramp.rests();
  }

  /// The outcome after a wait that ended without reaching its target.
  /// @param what the target, such as "the velocity of 1024 UU/s (90.00 deg/s)"
  /// @param demand reached, in the same unit
  /// @param limits the limits that apply in the drive
  [[nodiscard]] Outcome outcome(AxesCall& call, const std::string& what, const std::string& demand,
                                const std::string& limits) const {
    if (Outcome halted = check_halt(call); !halted) return halted;
    const AxisSnapshot& axis = call.snapshot();
    if (Outcome ended = limit_switch.outcome(axis, call.unit_of(axis.id), what); !ended) {
      return ended;
    }
    return Outcome::failed("axis " + to_string(axis.id) + ": " + what + " is limited to " + demand +
                           " by " + limits);
  }
};

/// Sends the velocity and waits until it is in force, not until it is reached.
Outcome start_velocity(AxesCall& call, EndlessMotion& motion, std::int32_t velocity,
                       const VelocityOptions& options) {
  return enter(call, OperatingMode::profile_velocity,
               std::array{Setting{"profile_acc"_object, options.acceleration},
                          Setting{"profile_dec"_object, options.deceleration},
                          Setting{"target_velocity"_object, velocity}},
               &motion);
}

/// The demand can be at its target while the axis is still approaching it.
/// @return a text such as "at 512 UU/s (45.00 deg/s) of 1024 UU/s (90.00 deg/s), still changing".
std::string velocity_progress(const AxesCall& call, std::int32_t velocity) {
  const AxisStatus& status = call.snapshot().status;
  const std::int32_t demand = status.velocity_demand_value;
  const std::int32_t speed = demand == velocity ? status.load_velocity_actual_value : demand;
  return "at " + call.velocity_text(speed) + " of " + call.velocity_text(velocity) +
         ", still changing";
}

/// Starts the velocity and waits until it is reached, if the options ask for that.
Outcome reach_velocity(AxesCall& call, EndlessMotion& motion, std::int32_t velocity,
                       const VelocityOptions& options, const Wakeup& wakeup) {
  std::int64_t slowest = 0;
  if (Outcome good = check_velocity(call, velocity, options, slowest); !good) return good;
  Outcome started = start_velocity(call, motion, velocity, options);
  if (!started || options.call.until == Until::in_force) return started;
  Obstacles obstacles{.limit_switch = {}, .ramp = {slowest, call.period()}};
  Outcome seen = call.await_enabled(kVelocityReached, call.tick(), [&](const AxisSnapshot& axis) {
    // The demand can be at its target while the axis is still approaching it.
    const std::int32_t demand = axis.status.velocity_demand_value;
    if (demand != velocity) obstacles.note(axis, velocity, demand);
    return has_velocity(axis) || (demand != velocity && obstacles.keep_back(axis));
  });
  if (!seen) {
    seen = explained(std::move(seen), call, wakeup, "at its velocity");
    return with_progress(std::move(seen), call, kVelocityReached,
                         velocity_progress(call, velocity));
  }
  if (has_velocity(call.snapshot())) return check_halt(call);
  return obstacles.outcome(
      call, "the velocity of " + call.velocity_text(velocity),
      call.velocity_text(call.snapshot().status.velocity_demand_value),
      "the app_speed_limit (607Fh) or the motor_max_speed_rpm (6080h) that the "
      "axis had when it was enabled");
}

/// Brakes to standstill with 60FFh = 0, also after an interrupt.
Outcome end_velocity(AxesCall& call, const Wakeup& wakeup, std::chrono::nanoseconds timeout) {
  const Wakeup::StopInProgress in_progress(wakeup);
  Round round = call.round_to(every_axis);
  add_settings(round.entries.front().command,
               std::array{Setting{"target_velocity"_object, std::int64_t{0}}});
  if (Outcome done = call.put_in_force({&round, 1}); !done) return done;
  call.set_timeout(timeout);
  return call.await_enabled("standstill, bit 12", call.tick(), [](const AxisSnapshot& axis) {
    return axis.status.velocity_demand_value == 0 && axis.shows(Statusword::kSpeedZero);
  });
}

/// @return the session that has taken the axis and commanded it; nothing if there is none.
std::optional<AxisOwner> new_master(SessionCore& core, const AxisSnapshot& axis) {
  const bool is_other = axis.owner_session != 0 && axis.owner_session != core.id;
  if (!is_other || axis.last_sequence == 0) return std::nullopt;
  return AxisOwner{.axis = axis.id,
                   .session = axis.owner_session,
                   .name = core.names.find(axis.id.bench, axis.owner_session)};
}

/// Stops the axis of a jog with a quick stop if the end of the jog was refused or not seen. A quick
/// stop needs no control: the axis may be free by now, or taken by a session that has not commanded
/// it yet. An axis that another session has commanded is left to that session.
/// @return `cause`, with the result of the stop.
Outcome stop_instead(const std::shared_ptr<SessionCore>& core, const AxisId& id,
                     const Outcome& cause, std::chrono::nanoseconds timeout) {
  AxesCommand stop(core, layout_of(id), Caller::axis, EachCommand::quick_stop,
                   {.timeout = timeout});
  stop.begin();
  const bool is_seen = !stop.call().snapshots().empty();
  if (const auto master = is_seen ? new_master(*core, stop.call().snapshot()) : std::nullopt) {
    return cause.kind() == OutcomeKind::refused
               ? cause.with_owner(*master)
               : cause.with_prefix(to_string(*master) + " at present: ");
  }
  if (is_seen && !has_no_fault(stop.call().snapshot())) return cause;  // a fault stops it
  stop.carry_out();
  const Outcome stopped = stop.outcome();
  if (stopped) return cause.with_prefix("a quick stop ended the jog: ");
  return cause.with_prefix("axis " + to_string(id) +
                           " was not seen to stop, its quick stop failed (" + stopped.message() +
                           "): ");
}

/// Brakes the axis of a jog and waits for standstill, falling back to a quick stop.
Outcome end_jog(const std::shared_ptr<SessionCore>& core, AxesCall& call,
                std::chrono::nanoseconds timeout) {
  Outcome ended = end_velocity(call, core->wakeup, timeout);
  // A fault has its own reaction. A stop would not reach a lost bench, but its watchdog acts.
  if (ended || !is_enabled(call.snapshot()) || ended.kind() == OutcomeKind::lost) return ended;
  if (call.is_superseded()) return ended;  // another thread now commands the axis
  return stop_instead(core, call.snapshot().id, ended, timeout);
}

/// A stop, a fault or a loss of control leaves 60FFh unchanged, and the axis would run when enabled
/// again. An axis of another session is left alone; a lost bench cannot be reached.
void clear_velocity(Axis& axis, const Outcome& ended) {
  if (ended.kind() == OutcomeKind::lost || !axis.acquire()) return;
  (void)axis.write(kTargetVelocity, 0);
}

/// The command may have taken effect even if the wait for it failed.
void end_failed_start(const std::shared_ptr<SessionCore>& core, AxesCall& call,
                      const Outcome& started, std::chrono::nanoseconds timeout) {
  if (started.kind() == OutcomeKind::refused || call.is_superseded()) return;
  if (is_enabled(call.snapshot())) (void)end_jog(core, call, timeout);
}

/// The last step of every jog. A superseded axis is left alone: another thread commands it now.
/// @return `ended`, naming the session that has taken the axis.
Outcome conclude_jog(Axis& axis, SessionCore& core, const AxesCall& call, Outcome ended) {
  if (!ended && !call.is_superseded()) clear_velocity(axis, ended);
  const AxisId id = axis.id();
  return explain_loss(core, std::move(ended), {&id, 1});
}

// ---- torque ----------------------------------------------------------------------------------

constexpr std::string_view kTorqueReached = "the torque, bit 10";

ObjectRow relative_limit_of(std::int16_t torque) {
  return torque > 0 ? "positive_torque_limit_relative"_object
                    : "negative_torque_limit_relative"_object;
}

/// Names the limits that can keep a torque from being reached although it is below each of them:
/// 60E0h and 60E1h also limit the current.
std::string torque_limits(std::int16_t torque) {
  return object_text(kObjectRows["max_torque"_object].address) + " or " +
         object_text(vdrive::describe(relative_limit_of(torque)).address) +
         ", which also limits the current";
}

/// @return the objects that check_torque() compares with.
std::array<ObjectAddress, 3> torque_objects(std::int16_t torque) {
  return {kObjectRows["torque_slope"_object].address, kObjectRows["max_torque"_object].address,
          vdrive::describe(relative_limit_of(torque)).address};
}

/// @param slope receives the slope that will be in force
/// @return refused if the drive would accept the torque and never apply it.
Outcome check_torque(AxesCall& call, std::int16_t torque, const TorqueOptions& options,
                     std::int64_t& slope) {
  const ObjectRow relative = relative_limit_of(torque);
  const auto values = call.take_values();
  if (!values) return values.outcome();
  const std::vector<std::int64_t>& read = values->front();
  slope = options.slope.value_or(read[0]);
  const std::int64_t wanted = std::abs(std::int64_t{torque});
  const auto above = [&](ObjectRow limit, std::int64_t value) {
    // NOLINTNEXTLINE(readability-suspicious-call-argument): a torque is the value here
    return above_limit(call.snapshot().id, user_unit(), "torque", torque, limit, value);
  };
  if (wanted > read[1]) return above("max_torque"_object, read[1]);
  // 0 disables the relative limit.
  if (read[2] != 0 && wanted > read[2]) return above(relative, read[2]);
  return {};
}

/// Applies the torque and waits until it is reached, if the options ask for that.
Outcome reach_torque(AxesCall& call, EndlessMotion& motion, std::int16_t torque,
                     const TorqueOptions& options, const Wakeup& wakeup) {
  std::int64_t slope = 0;
  if (Outcome good = check_torque(call, torque, options, slope); !good) return good;
  Outcome started = enter(call, OperatingMode::profile_torque,
                          std::array{Setting{"torque_slope"_object, options.slope},
                                     Setting{"target_torque"_object, torque}},
                          &motion);
  if (!started || options.call.until == Until::in_force) return started;
  Obstacles obstacles{.limit_switch = {}, .ramp = {slope, call.period()}};
  Outcome seen = call.await_enabled(kTorqueReached, call.tick(), [&](const AxisSnapshot& axis) {
    const std::int16_t demand = axis.status.torque_demand;
    if (demand != torque) obstacles.note(axis, torque, demand);
    return target_reached(axis) || (demand != torque && obstacles.keep_back(axis));
  });
  if (!seen) {
    seen = explained(std::move(seen), call, wakeup, "with its torque");
    return with_progress(std::move(seen), call, kTorqueReached,
                         "at " + std::to_string(call.snapshot().status.torque_demand) + " of " +
                             std::to_string(torque) + " per mille of rated torque, still changing");
  }
  if (target_reached(call.snapshot())) return check_halt(call);
  return obstacles.outcome(call, "the torque of " + std::to_string(torque),
                           std::to_string(call.snapshot().status.torque_demand),
                           torque_limits(torque));
}

}  // namespace

Outcome Axis::home(const HomingOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = begin_motion(call, options.call.timeout, "homing", homing_objects(options));
      !ready)
    return ready;
  if (is_homing(call.snapshot())) {
    return not_in_this_state("axis " + to_string(id_) + ": a homing run is in progress");
  }
  if (Outcome good = check_homing_speeds(call, options); !good) return good;
  Outcome ready = enter(call, OperatingMode::homing,
                        std::array{Setting{"homing_method"_object, options.method},
                                   Setting{"home_offset"_object, options.offset},
                                   Setting{"homing_speed_search"_object, options.search_speed},
                                   Setting{"homing_speed_creep"_object, options.creep_speed},
                                   Setting{"homing_acceleration"_object, options.acceleration}});
  if (!ready) return explain_loss(*core_, std::move(ready), {&id_, 1});
  const auto start = static_cast<std::uint16_t>(kEnableOperation | Controlword::kStartHoming);
  if (Outcome started = call.put_in_force({start}); !started) {
    return explain_loss(*core_, std::move(started), {&id_, 1});
  }
  if (options.call.until == Until::in_force) return {};
  // From here on, bits 13, 12 and 10 belong to this run, which began in the observed tick. A drive
  // that has not evaluated the controlword yet still shows the old bits.
  const AnswerTime answer_time(call, kLongestLoop);
  bool has_begun = false;
  Outcome seen = call.await_enabled(kEndOfHoming, call.tick(), [&](const AxisSnapshot& axis) {
    has_begun = has_begun || !target_reached(axis);
    return target_reached(axis) && (has_begun || answer_time.has_ended());
  });
  if (!seen) {
    seen = explained(std::move(seen), call, core_->wakeup, "with its homing run");
    seen = with_progress(std::move(seen), call, kEndOfHoming, homing_progress(call));
    return explain_loss(*core_, std::move(seen), {&id_, 1});
  }
  Outcome result = homing_result(call);
  Outcome dropped = call.put_in_force({kEnableOperation});  // clear bit 4 for the next edge
  if (dropped) dropped = await_controlword_loop(call);
  return result ? explain_loss(*core_, dropped, {&id_, 1}) : result;
}

Outcome Axis::run_at(std::int32_t velocity, const VelocityOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = begin_motion(call, options.call.timeout, "a velocity", kVelocityObjects);
      !ready)
    return ready;
  EndlessMotion motion(*core_, call);
  Outcome outcome = reach_velocity(call, motion, velocity, options, core_->wakeup);
  if (outcome) motion.settle();
  return explain_loss(*core_, std::move(outcome), {&id_, 1});
}

Outcome Axis::apply_torque(std::int16_t torque, const TorqueOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = begin_motion(call, options.call.timeout, "a torque", torque_objects(torque));
      !ready)
    return ready;
  EndlessMotion motion(*core_, call);
  Outcome outcome = reach_torque(call, motion, torque, options, core_->wakeup);
  if (outcome) motion.settle();
  return explain_loss(*core_, std::move(outcome), {&id_, 1});
}

Outcome Axis::jog(std::int32_t velocity, const std::function<bool(const AxisSnapshot&)>& held,
                  const VelocityOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = begin_motion(call, options.call.timeout, "a jog", kVelocityObjects); !ready)
    return ready;
  std::int64_t slowest = 0;
  if (Outcome good = check_velocity(call, velocity, options, slowest); !good) return good;
  EndlessMotion motion(*core_, call);
  if (Outcome started = start_velocity(call, motion, velocity, options); !started) {
    end_failed_start(core_, call, started, options.call.timeout);
    return conclude_jog(*this, *core_, call, std::move(started));
  }
  call.set_timeout(kHeldAtMost);
  // Without control no watchdog guards the axis: end the jog immediately.
  const auto ends = [&](const AxisSnapshot& axis) {
    return axis.owner_session != core_->id || !held(axis);
  };
  Outcome seen;
  try {
    seen = call.await_enabled("the end of the jog", call.tick(), ends);
  } catch (...) {  // thrown by the program in `held`
    (void)conclude_jog(*this, *core_, call, end_jog(core_, call, options.call.timeout));
    throw;
  }
  if (seen.kind() == OutcomeKind::lost) return seen;
  if (!seen && (!is_enabled(call.snapshot()) || call.is_superseded())) {
    return conclude_jog(*this, *core_, call, std::move(seen));
  }
  Outcome ended = end_jog(core_, call, options.call.timeout);
  if (ended) motion.settle();
  return conclude_jog(*this, *core_, call, std::move(ended));
}

}  // namespace vdrive::client
