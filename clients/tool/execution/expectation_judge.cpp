// SPDX-License-Identifier: Apache-2.0
#include "execution/expectation_judge.hpp"

#include "execution/axis_states.hpp"
#include "output/report.hpp"
#include "values/condition.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/number_text.hpp"

#include <optional>
#include <span>
#include <string>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;
using client::OutcomeKind;

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
  std::optional<client::AxisSnapshot> in_fault;  // it stays there
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
    // Time passes by itself: a value that was just written is read once it is in force.
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

/// Another program could have written the value also in Fault.
Outcome ExpectationJudge::late(const ValueObserver& observer, const Expectation& expectation,
                               const FaultWatch& fault) {
  const client::AxisSnapshot& axis = observer.shown();
  Outcome other = differs(expectation, observer.value(), observer.tick(), axis.mode());
  if (!is_fault(axis.state())) return other;
  return other.with_message(other.message() + "; " + fault_text(session_, axis, fault));
}

/// An axis that this session has lost does not do what the scenario commanded any more.
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
  found_ = Json{{"expected", expectation.value}, {"actual", actual}, {"tick", tick}};
  add_in_unit(*found_, expectation.object.row(), expectation.unit, "expected", expectation.value);
  add_in_unit(*found_, expectation.object.row(), expectation.unit, "actual", actual);
  std::string message = expectation.object.text + ": expected " + expected_text(expectation) +
                        ", actual " + value_text(expectation.object, actual, expectation.unit) +
                        " at tick " + std::to_string(tick);
  const std::string decoded = decoded_text(expectation, actual, mode);
  if (!decoded.empty()) message += ": " + decoded;
  return Outcome::failed(std::move(message));
}

}  // namespace vdrive::tool
