// SPDX-License-Identifier: Apache-2.0
#include "execution/expectation_judge.hpp"

#include "execution/axis_states.hpp"
#include "output/event_view.hpp"
#include "output/report.hpp"
#include "values/condition.hpp"
#include "values/expectation.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

// Longer than a reset takes, and than any motor needs until its motion is visible.
constexpr std::chrono::milliseconds kStandstill{100};

// A drive without power coasts. Below this speed, the value is encoder noise at standstill.
constexpr std::int32_t kRest = 20;  // [UU/s]

bool is_at_rest(const client::AxisSnapshot& axis) {
  return std::abs(axis.status.load_velocity_actual_value) <= kRest;
}

// next() is called again after this time: only a lost bench ends the wait.
constexpr std::chrono::milliseconds kPatienceOfObserver{500};

}  // namespace

/// Detects an axis that is in Fault (CiA 402, power state machine) and at rest: a wait for anything
/// but the fault and its reset cannot succeed.
class FaultWatch {
 public:
  /// @param period of the bench [us]
  explicit FaultWatch(std::chrono::microseconds period)
      : patience_(client::ticks_of(kStandstill, period)) {}

  /// @param axis its next observation
  void note(const client::AxisSnapshot& axis) {
    if (!is_fault(axis.state())) {
      was_sound_ = true;
      fault_tick_ = 0;
    } else if (fault_tick_ == 0) {
      fault_tick_ = axis.tick;
    }
    const bool stays = axis.state() == PowerState::fault && is_at_rest(axis);
    if (!stays) since_.reset();
    if (stays && !since_) since_ = axis.driven_tick();
    is_over_ = since_ && axis.driven_tick() - *since_ >= patience_;
  }

  /// @return whether the axis has been in Fault and at rest for 100 ms of drive time.
  [[nodiscard]] bool is_over() const noexcept { return is_over_; }

  /// @return the tick in which the axis was first observed with its fault, 0 without one.
  [[nodiscard]] std::uint64_t first_tick() const noexcept { return fault_tick_; }

  /// @return whether the axis was observed before its fault: then first_tick() is the tick of the
  ///         fault.
  [[nodiscard]] bool saw_begin() const noexcept { return was_sound_; }

 private:
  std::uint64_t patience_;              ///< [ticks]
  bool was_sound_ = false;              ///< observed before the fault
  bool is_over_ = false;                ///< nothing can follow without a reset
  std::uint64_t fault_tick_ = 0;        ///< of the first observation with a fault
  std::optional<std::uint64_t> since_;  ///< driven tick since which it is in Fault and at rest
};

/// Observes one object of an axis in each tick, starting with the tick in which the last write
/// takes effect.
class ValueObserver {
 public:
  ValueObserver(client::Session& session, client::Axis& axis, ObjectAddress object)
      : session_(session), axis_(axis), object_(object) {}

  /// Makes the first observation. @param in_force the earliest tick that counts
  Outcome start(const client::BenchInfo& bench, std::uint64_t in_force) {
    is_lockstep_ = bench.clock_mode == client::ClockMode::lockstep;
    auto follower = session_.follow({axis_.id()}, client::Pace::drive);
    if (!follower) return follower.outcome();
    follower_ = std::move(*follower);
    const client::AxisId id = axis_.id();
    if (Outcome seen = see(session_.observe({&id, 1})); !seen) return seen;
    while (tick_ < in_force) {
      if (Outcome seen = next(); !seen) return seen;
    }
    missed_ = 0;
    return {};
  }

  /// Observes the next tick.
  Outcome next() {
    ensure(follower_.has_value(), "the observer was started");
    while (true) {
      auto sample = follower_->next(kPatienceOfObserver);
      // No tick yet, for example because the machine is busy: keeps waiting.
      if (sample.outcome().kind() == client::OutcomeKind::timed_out) continue;
      return see(std::move(sample));
    }
  }

  /// @return whether every tick can be observed: always in lock-step, otherwise if the status
  ///         stream contains the object.
  [[nodiscard]] bool sees_every_tick() const { return is_lockstep_ || is_streamed_; }

  [[nodiscard]] std::uint64_t tick() const { return tick_; }

  /// tick() minus the ticks that the tick number skipped; use this for durations.
  [[nodiscard]] std::uint64_t driven_tick() const { return shown_.driven_tick(); }

  /// The latest observation of the axis.
  [[nodiscard]] const client::AxisSnapshot& shown() const { return shown_; }

  [[nodiscard]] std::int64_t value() const { return value_; }

  /// Samples of the stream lost since the first observation.
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

 private:
  Outcome see(client::Result<client::Observation> sample) {
    if (!sample) return sample.outcome();
    ensure(!sample->axes.empty(), "an observation has the axis that is observed");
    tick_ = sample->tick;
    missed_ += sample->missed;
    shown_ = sample->axes.front();
    const auto streamed = client::value_of(shown_, object_);
    is_streamed_ = streamed.has_value();
    if (streamed) {
      value_ = *streamed;
      return {};
    }
    const auto read = axis_.read(object_);
    if (!read) return read.outcome();
    value_ = *read;
    return {};
  }

  client::Session& session_;
  client::Axis& axis_;
  ObjectAddress object_;
  std::optional<client::Follower> follower_;
  bool is_lockstep_ = false;
  bool is_streamed_ = false;
  std::uint64_t tick_ = 0;
  std::uint64_t missed_ = 0;
  std::int64_t value_ = 0;
  client::AxisSnapshot shown_;
};

namespace {

/// Describes the fault of an axis. The tick of a fault older than the watch comes from the events
/// that the bench keeps: kept_events() takes half a second, and replaces the observer of
/// Session::on_event.
/// @param axis with a fault, as last observed by `watch`
/// @return such as "axis 1.1 is in Fault 0x8611 following error, since tick 1204".
std::string fault_text(client::Session& session, const client::AxisSnapshot& axis,
                       const FaultWatch& watch) {
  const auto tick = watch.saw_begin()
                        ? std::optional(watch.first_tick())
                        : tick_of_fault(kept_events(session), axis.id, axis.status.error_code);
  return "axis " + to_string(axis.id) + " is in " + state_text(axis) + ", since tick " +
         (tick ? std::to_string(*tick) : std::to_string(watch.first_tick()) + " or before");
}

/// @return whether a drive in Fault cannot show the condition (condition_names()) without a reset
///         and further commands. Within reach are the state after a reset and the conditions that
///         depend on the supply and on limits.
bool is_out_of_reach_in_fault(std::string_view condition) noexcept {
  constexpr std::array<std::string_view, 5> kComeInFault{
      "switch_on_disabled", "voltage_enabled", "internal_limit_active", "warning", "remote"};
  return std::ranges::find(kComeInFault, condition) == kComeInFault.end();
}

/// @return the same for a value. Out of reach are: a position, a speed, a torque, a current, the
///         active mode (6061h), and a statusword that has no fault, is in Operation enabled, has
///         reached a target, or has bit 12 set. Within reach are objects that another program may
///         write, such as 6081h, and effects of a reset, the supply or an input.
bool is_out_of_reach_in_fault(const Expectation& expectation) {
  using namespace literals;
  const auto row = expectation.object.row();
  if (!row) return false;
  constexpr std::array kOfMotion{"torque_demand"_object, "torque_actual_value"_object,
                                 "current_actual_value"_object, "op_mode_actual"_object};
  const bool is_of_motion =
      dimension_of(*row) || std::ranges::find(kOfMotion, *row) != kOfMotion.end();
  if (is_of_motion) return describe(*row).access == Access::read_only;  // an actual value
  if (*row != "ds402_statusword"_object || expectation.comparison != Comparison::equal)
    return false;
  constexpr std::uint64_t kSwitchOnDisabled = 1U << 6U;
  const std::uint64_t mask = expectation.mask.value_or(~std::uint64_t{0});
  const auto value = static_cast<std::uint64_t>(expectation.value);
  // Bit 12 belongs to the mode, which sets it only in Operation enabled.
  constexpr std::uint64_t kNeverInFault =
      Statusword::kOperationEnabled | Statusword::kTargetReached | Statusword::kSetPointAcknowledge;
  const bool needs_no_fault = (mask & Statusword::kFault) != 0 && (value & Statusword::kFault) == 0;
  const bool needs_power = (value & mask & kNeverInFault) != 0;
  return (needs_no_fault || needs_power) && (value & mask & kSwitchOnDisabled) == 0;
}

Outcome not_every_tick(const ValueObserver& observer) {
  return Outcome::failed(std::to_string(observer.missed()) +
                         " samples of the status stream were lost before tick " +
                         std::to_string(observer.tick()) + ": --throughout did not see every tick");
}

}  // namespace

Outcome ExpectationJudge::judge(client::Axis& axis, const Expectation& expectation) {
  if (!expectation.object.address) return unknown_object(axis.id(), expectation.object);
  if (!expectation.within && !expectation.throughout) return compare(axis, expectation);
  const auto bench = session_.find_bench(axis.id().bench);
  if (!bench) return bench.outcome();
  ValueObserver observer(session_, axis, *expectation.object.address);
  if (Outcome seen = observer.start(*bench, in_force_[axis.id()]); !seen) return seen;
  return expectation.within ? within(observer, *bench, expectation)
                            : throughout(observer, *bench, expectation);
}

Outcome ExpectationJudge::await(const client::Axis& axis, const std::string& condition,
                                Duration limit) {
  const auto bench = session_.find_bench(axis.id().bench);
  if (!bench) return bench.outcome();
  FaultWatch fault(bench->period);
  const bool ends_in_fault = is_out_of_reach_in_fault(condition);
  Outcome held;
  std::optional<client::AxisSnapshot> in_fault;  // set once it stays in Fault
  const auto shown = axis.wait_until(
      [&](const client::AxisSnapshot& now) {
        if (tool::shows(now, condition)) return true;
        held = check_control(now);
        fault.note(now);
        if (held && ends_in_fault && fault.is_over()) in_fault = now;
        return !held || in_fault.has_value();
      },
      limit);
  if (in_fault) {
    return Outcome::failed(fault_text(session_, *in_fault, fault) + "; waited for " + condition);
  }
  if (!held || shown) return held;
  if (shown.outcome().kind() != OutcomeKind::timed_out) return shown.outcome();
  const auto now = axis.status();
  return Outcome::timed_out("axis " + to_string(axis.id()) + ": timed out while waiting for " +
                            condition + (now ? ", " + client::what_it_shows(*now) : ""));
}

Outcome ExpectationJudge::compare(client::Axis& axis, const Expectation& expectation) {
  const auto bench = session_.find_bench(axis.id().bench);
  if (!bench) return bench.outcome();
  if (bench->clock_mode != client::ClockMode::lockstep) {
    // In real time, a value just written is read only once it is in force.
    const auto reached = session_.wait_for_tick(axis.id().bench, in_force_[axis.id()]);
    if (!reached) return reached.outcome();
  }
  ensure(expectation.object.address.has_value(), "an expectation is of one object");
  const auto readings = axis.read(std::span(&*expectation.object.address, 1));
  if (!readings) return readings.outcome();
  ensure(!readings->objects.empty(), "a read answers for each object");
  const client::ObjectReading& reading = readings->objects.front();
  if (reading.code != AbortCode::none) {
    return Outcome::refused(wire_code(reading.code),
                            "read of " + expectation.object.text + " refused");
  }
  if (expectation.accepts(reading.value)) return {};
  const auto shown = axis.status();
  return differs(expectation, reading.value, readings->tick,
                 shown ? shown->mode() : OperatingMode::none);
}

Outcome ExpectationJudge::within(ValueObserver& observer, const client::BenchInfo& bench,
                                 const Expectation& expectation) {
  const std::uint64_t last =
      observer.driven_tick() + client::ticks_of(*expectation.within, bench.period);
  FaultWatch fault(bench.period);
  const bool ends_in_fault = is_out_of_reach_in_fault(expectation);
  while (!expectation.accepts(observer.value())) {
    if (Outcome held = check_control(observer.shown()); !held) return held;
    fault.note(observer.shown());
    if (ends_in_fault && fault.is_over()) return ended_by_fault(observer, expectation, fault);
    if (observer.driven_tick() >= last) return late(observer, expectation, fault);
    if (Outcome seen = observer.next(); !seen) return seen;
  }
  return {};
}

Outcome ExpectationJudge::ended_by_fault(const ValueObserver& observer,
                                         const Expectation& expectation, const FaultWatch& fault) {
  const client::AxisSnapshot& axis = observer.shown();
  static_cast<void>(differs(expectation, observer.value(), observer.tick(), axis.mode()));
  found_->emplace("error_code", axis.status.error_code);
  return Outcome::failed(fault_text(session_, axis, fault) + "; waited for " +
                         expectation.object.text + " " + expected_text(expectation));
}

/// The axis may be in Fault here: that does not end the wait for a value that another program could
/// still write.
Outcome ExpectationJudge::late(const ValueObserver& observer, const Expectation& expectation,
                               const FaultWatch& fault) {
  const client::AxisSnapshot& axis = observer.shown();
  Outcome other = differs(expectation, observer.value(), observer.tick(), axis.mode());
  if (!is_fault(axis.state())) return other;
  return other.with_message(other.message() + "; " + fault_text(session_, axis, fault));
}

/// An axis that this session has lost no longer does what the scenario commands.
Outcome ExpectationJudge::check_control(const client::AxisSnapshot& axis) {
  if (axis.owner_session == session_.id()) {
    held_.insert(axis.id);
    return {};
  }
  if (!held_.contains(axis.id)) return {};
  const std::string owner =
      axis.owner_session == 0
          ? "no session controls it"
          : client::owner_text(axis.owner_session, owner_of(session_, axis)) + " controls it";
  return Outcome::lost("axis " + to_string(axis.id) + " was lost: " + owner + " at tick " +
                       std::to_string(axis.tick) + ", it " + client::what_it_shows(axis));
}

Outcome ExpectationJudge::throughout(ValueObserver& observer, const client::BenchInfo& bench,
                                     const Expectation& expectation) {
  if (!observer.sees_every_tick()) {
    return Outcome::failed(
        expectation.object.text +
        " is not in the status stream: --throughout can check it in every tick only in lock-step");
  }
  const std::uint64_t last =
      observer.driven_tick() + client::ticks_of(*expectation.throughout, bench.period);
  while (true) {
    if (Outcome held = check_control(observer.shown()); !held) return held;
    if (!expectation.accepts(observer.value())) {
      return differs(expectation, observer.value(), observer.tick(), observer.shown().mode());
    }
    if (observer.missed() != 0) return not_every_tick(observer);
    if (observer.driven_tick() >= last) return {};
    if (Outcome seen = observer.next(); !seen) return seen;
  }
}

Outcome ExpectationJudge::differs(const Expectation& expectation, std::int64_t actual,
                                  std::uint64_t tick, OperatingMode mode) {
  Record record{{"expected", expectation.value}, {"actual", actual}, {"tick", tick}};
  add_in_unit(record, expectation.object.row(), expectation.unit, "expected", expectation.value);
  add_in_unit(record, expectation.object.row(), expectation.unit, "actual", actual);
  found_ = record_json(record);
  std::string message = expectation.object.text + ": expected " + expected_text(expectation) +
                        ", actual " + value_text(expectation.object, actual, expectation.unit) +
                        " at tick " + std::to_string(tick);
  const std::string decoded = decoded_text(expectation, actual, mode);
  if (!decoded.empty()) message += ": " + decoded;
  return Outcome::failed(std::move(message));
}

}  // namespace vdrive::tool
