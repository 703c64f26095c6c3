// SPDX-License-Identifier: Apache-2.0
// The commands `expect` and `wait`: now, within a time, throughout a time.
#include "execution/executor.hpp"
#include "values/condition.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <chrono>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

constexpr std::chrono::milliseconds kPatienceOfExpectation{500};

std::string expected_text(const ExpectCommand& command) {
  std::string text = value_text(command.object, command.value);
  if (command.mask) {
    text = value_text(command.object, command.value & static_cast<std::int64_t>(*command.mask)) +
           " under mask " + hex(static_cast<std::uint32_t>(*command.mask), 8);
  }
  if (command.tolerance) text += " +- " + std::to_string(*command.tolerance);
  if (command.comparison == Comparison::equal) return text;
  return std::string(to_string(command.comparison)) + " " + text;
}

}  // namespace

/// Observes one object of an axis in tick after tick, from the tick on in which the last write is
/// in force.
class Executor::ValueObserver {
 public:
  ValueObserver(client::Session& session, client::Axis& axis, ObjectAddress object)
      : session_(session), axis_(axis), object_(object) {}

  /// The first observation. @param in_force the earliest tick that counts
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
    while (true) {
      auto sample = follower_->next(kPatienceOfExpectation);
      if (sample.outcome().kind() == OutcomeKind::timed_out) continue;  // a busy machine
      return see(std::move(sample));
    }
  }

  /// @return whether every tick of realtime can be observed: the status stream has the object.
  [[nodiscard]] bool sees_every_tick() const { return is_lockstep_ || is_streamed_; }

  [[nodiscard]] std::uint64_t tick() const { return tick_; }

  /// The same without the ticks that the number jumped over: for durations.
  [[nodiscard]] std::uint64_t driven_tick() const { return shown_.driven_tick(); }

  /// The axis as it was last observed.
  [[nodiscard]] const client::AxisSnapshot& shown() const { return shown_; }

  [[nodiscard]] std::int64_t value() const { return value_; }

  /// Samples of the stream lost since the first observation.
  [[nodiscard]] std::uint64_t missed() const { return missed_; }

 private:
  Outcome see(client::Result<client::Observation> sample) {
    if (!sample) return sample.outcome();
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

Outcome Executor::run(const ExpectCommand& typed) {
  auto axis = this->axis(typed.axis);
  if (!axis) return axis.outcome();
  const ExpectCommand command = in_user_units(*axis, typed);
  Outcome outcome = judge(*axis, command);
  if (is_quiet_) return outcome;
  if (is_json_) {
    Json json = object_json(axis->id(), command.object);
    add_outcome(json, named(outcome));
    json["comparison"] = to_string(command.comparison);
    json["expected"] = command.value;
    if (found_) json.update(*found_);
    terminal_.print(to_line(json));
  } else if (outcome) {
    terminal_.print(label_of(axis->id()) + " " + command.object.text + ": " +
                    expected_text(command) + ", as expected");
  }
  return outcome;
}

Outcome Executor::judge(client::Axis& axis, const ExpectCommand& command) {
  if (!command.object.address) return unknown_object(axis.id(), command.object);
  if (!command.within && !command.throughout) return compare(axis, command);
  const auto bench = bench_of(axis.id());
  if (!bench) return bench.outcome();
  ValueObserver observer(session_, axis, *command.object.address);
  if (Outcome seen = observer.start(*bench, in_force_[axis.id()]); !seen) return seen;
  return command.within ? expect_within(observer, command) : expect_throughout(observer, command);
}

Outcome Executor::run(const AwaitCommand& command) {
  constexpr std::chrono::seconds kLimit{60};  // of drive time, as for a motion
  auto axis = this->axis(command.axis);
  if (!axis) return axis.outcome();
  const Duration limit = timeout_.value_or(kLimit);
  Outcome outcome;
  if (command.expectation) {
    ExpectCommand expectation = in_user_units(*axis, *command.expectation);
    expectation.within = limit;
    outcome = judge(*axis, expectation);
    if (found_) outcome = Outcome::timed_out(outcome.message());
  } else {
    outcome = await(*axis, command.condition, limit);
  }
  return report_motion(*axis, "wait", std::move(outcome), false);
}

Outcome Executor::await(const client::Axis& axis, const std::string& condition, Duration limit) {
  Outcome held;
  const auto shown = axis.wait_until(
      [&](const client::AxisSnapshot& now) {
        if (tool::shows(now, condition)) return true;
        held = check_control(now);
        return !held;
      },
      limit);
  if (!held || shown) return held;
  if (shown.outcome().kind() != OutcomeKind::timed_out) return shown.outcome();
  const auto now = axis.status();
  return Outcome::timed_out("axis " + to_string(axis.id()) + ": timed out while waiting for " +
                            condition + (now ? ", " + client::what_it_shows(*now) : ""));
}

Outcome Executor::compare(client::Axis& axis, const ExpectCommand& command) {
  const auto bench = bench_of(axis.id());
  if (!bench) return bench.outcome();
  if (bench->clock_mode != client::ClockMode::lockstep) {
    // Time passes by itself: a value that was just written is read once it is in force.
    const auto reached = session_.wait_for_tick(axis.id().bench, in_force_[axis.id()]);
    if (!reached) return reached.outcome();
  }
  const auto readings = axis.read(std::span(&*command.object.address, 1));
  if (!readings) return readings.outcome();
  const client::ObjectReading& reading = readings->objects.front();
  if (reading.code != AbortCode::none) {
    return Outcome::refused(wire_code(reading.code), "read of " + command.object.text + " refused");
  }
  if (command.accepts(reading.value)) return {};
  return differs(command, reading.value, readings->tick);
}

Outcome Executor::expect_within(ValueObserver& observer, const ExpectCommand& command) {
  const auto bench = bench_of(axes_.at(command.axis).id());
  if (!bench) return bench.outcome();
  const std::uint64_t last =
      observer.driven_tick() + client::ticks_of(*command.within, bench->period);
  while (!command.accepts(observer.value())) {
    if (Outcome held = check_control(observer.shown()); !held) return held;
    if (observer.driven_tick() >= last) return differs(command, observer.value(), observer.tick());
    if (Outcome seen = observer.next(); !seen) return seen;
  }
  return {};
}

/// An axis that this session has lost does not do what the scenario commanded any more.
Outcome Executor::check_control(const client::AxisSnapshot& axis) {
  if (axis.owner_session == session_.id()) {
    held_.insert(axis.id);
    return {};
  }
  if (!held_.contains(axis.id)) return {};
  const std::string owner = axis.owner_session == 0
                                ? "no session controls it"
                                : "session " + hex(axis.owner_session, 16) + " controls it";
  return Outcome::lost("axis " + to_string(axis.id) + " was lost: " + owner + " at tick " +
                       std::to_string(axis.tick) + ", it " + client::what_it_shows(axis));
}

Outcome Executor::expect_throughout(ValueObserver& observer, const ExpectCommand& command) {
  if (!observer.sees_every_tick()) {
    return Outcome::failed(
        command.object.text +
        " is not in the status stream: --throughout can check it in every tick only in lock-step");
  }
  const auto bench = bench_of(axes_.at(command.axis).id());
  if (!bench) return bench.outcome();
  const std::uint64_t last =
      observer.driven_tick() + client::ticks_of(*command.throughout, bench->period);
  while (true) {
    if (Outcome held = check_control(observer.shown()); !held) return held;
    if (!command.accepts(observer.value()))
      return differs(command, observer.value(), observer.tick());
    if (observer.missed() != 0) {
      return Outcome::failed(std::to_string(observer.missed()) +
                             " samples of the status stream were lost before tick " +
                             std::to_string(observer.tick()) +
                             ": --throughout did not see every tick");
    }
    if (observer.driven_tick() >= last) return {};
    if (Outcome seen = observer.next(); !seen) return seen;
  }
}

Outcome Executor::differs(const ExpectCommand& command, std::int64_t actual, std::uint64_t tick) {
  found_ = Json{{"expected", command.value}, {"actual", actual}, {"tick", tick}};
  std::string message = command.object.text + ": expected " + expected_text(command) + ", actual " +
                        value_text(command.object, actual) + " at tick " + std::to_string(tick);
  return Outcome::failed(std::move(message));
}

}  // namespace vdrive::tool
