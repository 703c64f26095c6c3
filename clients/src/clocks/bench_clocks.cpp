// SPDX-License-Identifier: Apache-2.0
#include "clocks/bench_clocks.hpp"

#include "base/ask.hpp"
#include "streams/status_feed.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using Clock = Wakeup::Clock;
using std::chrono::milliseconds;

// Limit per request, so that an interrupt or a lost service is noticed between requests.
constexpr std::uint64_t kTicksPerRequest = 2000;

constexpr std::size_t kAxesPerRequest = msg::MAX_AXES_PER_FRAME;

// Short, because the service may be gone already when the session ends.
constexpr Patience kLeaveAnswer{milliseconds(500), false};

/// Wall time until the deadline, which may have passed.
milliseconds left_until(Clock::time_point deadline) {
  return std::max(milliseconds(0), std::chrono::ceil<milliseconds>(deadline - Clock::now()));
}

std::string step_of(const Target& target) {
  return "step of " + name_of(target);
}

wire::ClockOfBench clock_of(const BenchKey& key) {
  return {.bench = key.number, .incarnation = key.incarnation};
}

/// @return whether a step was accepted: it has ended, or it waits for another stepper.
bool is_accepted(const msg::Reply& reply) {
  return reply.reason == msg::Reason::none || reply.reason == msg::Reason::missing_stepper;
}

/// @return the next request of a step; its ticks and axes are removed from `ticks` and `axes`. It
///         names axes only when no ticks are left, so that they show the state after the step.
msg::Request next_request(std::uint64_t& ticks, std::span<const std::uint16_t>& axes) {
  const std::uint64_t some = std::min(ticks, kTicksPerRequest);
  ticks -= some;
  const auto shown = axes.first(ticks == 0 ? std::min(axes.size(), kAxesPerRequest) : 0);
  axes = axes.subspan(shown.size());
  return ask::step(some, {shown.begin(), shown.end()});
}

/// Replaces `samples` from place `first` on with the axes of an answer.
void fill_samples(const RequestAnswer& answer, std::size_t first,
                  std::vector<AxisSnapshot>& samples) {
  samples.resize(first + answer.axes.size());
  for (std::size_t i = 0; i < answer.axes.size(); ++i) {
    fill_sample(answer.axes[i], samples[first + i]);
  }
}

}  // namespace

BenchClocks::BenchClocks(std::uint64_t session, Exchange& exchange, HeldAxes& held_axes,
                         Discovery& discovery, const Wakeup& wakeup, wire::Participant& participant)
    : session_(session),
      exchange_(exchange),
      held_axes_(held_axes),
      discovery_(discovery),
      wakeup_(wakeup),
      participant_(participant) {}

Result<std::uint64_t> BenchClocks::set_rate(const Target& target, double rate) {
  const auto reply = exchange_.request(target, ask::set_rate(rate), "rate of " + name_of(target));
  if (!reply) return reply.outcome();
  discovery_.set_rate(target.key, rate);
  return reply->tick;
}

// ---- steppers ---------------------------------------------------------------------------------

Result<std::uint64_t> BenchClocks::join(const Target& target, std::uint32_t steppers) {
  if (grant_of(target.key)) {
    return Outcome::failed("this session has joined the clock of " + name_of(target) + " already");
  }
  if (Outcome free = note_thread(target); !free) return free;
  const auto reply = exchange_.request(target, ask::join_clock(steppers),
                                       "joining the clock of " + name_of(target));
  if (!reply) {
    forget_thread(target.key);
    return reply.outcome();
  }
  const std::scoped_lock lock(mutex_);
  grants_[target.key] = {.granted = reply->tick, .reached = reply->tick};
  return reply->tick;
}

void BenchClocks::leave(const Target& target) {
  {
    // Before the bench is told: a call that steps in the meantime must not rely on the grant.
    const std::scoped_lock lock(mutex_);
    grants_.erase(target.key);
  }
  forget_thread(target.key);
  const auto number = exchange_.send(target, ask::leave_clock());
  if (number) (void)exchange_.await(target, *number, kLeaveAnswer);  // the service may be gone
}

void BenchClocks::leave_all() {
  std::vector<BenchKey> joined;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [key, grant] : grants_) joined.push_back(key);
  }
  for (const BenchKey& key : joined) leave({.key = key});
}

void BenchClocks::abandon() noexcept {
  participant_.leave_clocks(session_);
}

Outcome BenchClocks::note_thread(const Target& target) {
  const std::uint64_t other = participant_.join_clock(clock_of(target.key), session_);
  if (other == 0) return {};
  return Outcome::refused(wire::number(msg::Reason::missing_stepper),
                          "this thread has joined the clock of " + name_of(target) +
                              " already, with session " + session_text(other) +
                              ": a step of one would wait forever for the other; join the clock in "
                              "the thread that steps it, or step all benches with one session");
}

void BenchClocks::forget_thread(const BenchKey& key) {
  participant_.leave_clock(clock_of(key), session_);
}

Result<StepLock> BenchClocks::lock_steps(const Target& target, Clock::time_point deadline) {
  std::unique_lock state(mutex_);
  if (!grants_.contains(target.key)) return StepLock();
  TurnMutex& steps = steps_[target.key];
  state.unlock();  // the lock of the steps must be taken before this one
  StepLock lock(steps, deadline);
  if (!lock) {
    return Outcome::timed_out("another thread of this session steps " + name_of(target) +
                              ", and its step has not ended");
  }
  return lock;
}

bool BenchClocks::steps_at_once(const Target& target, std::uint64_t ticks) const {
  return ticks <= kTicksPerRequest && !grant_of(target.key);
}

std::optional<Grant> BenchClocks::grant_of(const BenchKey& key) const {
  const std::scoped_lock lock(mutex_);
  const auto grant = grants_.find(key);
  return grant == grants_.end() ? std::nullopt : std::optional(grant->second);
}

Result<PendingStep> BenchClocks::begin_step_to(const Target& target, std::uint64_t tick,
                                               std::vector<std::uint16_t> shown) {
  PendingStep step;
  {
    const std::scoped_lock lock(mutex_);
    const auto grant = grants_.find(target.key);
    if (grant == grants_.end()) {
      return Outcome::refused(wire::number(msg::Reason::not_a_stepper),
                              step_of(target) + " refused");
    }
    const std::uint64_t granted = grant->second.granted;
    step.ticks = tick > granted ? tick - granted : 0;
    // Recorded before it is sent: two concurrent calls must not grant the same ticks.
    grant->second.granted += step.ticks;
  }
  // The step waits for the commands that were sent before it.
  const auto number = exchange_.send(
      target, ask::step(step.ticks, std::move(shown), held_axes_.last_sequence(target.key)));
  if (!number) return number.outcome();
  step.request = *number;
  return step;
}

void BenchClocks::note_reply(const BenchKey& key, const PendingStep& step,
                             const msg::Reply& reply) {
  const std::scoped_lock lock(mutex_);
  const auto grant = grants_.find(key);
  if (grant == grants_.end()) return;
  if (is_accepted(reply)) {
    grant->second.reached = std::max(grant->second.reached, reply.tick);
  } else if (reply.reason == msg::Reason::not_a_stepper) {  // removed from the clock
    grants_.erase(grant);
    forget_thread(key);
  } else {
    grant->second.granted -= step.ticks;
  }
}

/// @return the reply to a step: the tick reached, or REASON_MISSING_STEPPER if it still waits.
Result<RequestAnswer> BenchClocks::conclude_step(const Target& target, const PendingStep& step,
                                                 Clock::time_point deadline, Silence silence) {
  auto reply = exchange_.await(target, step.request, {left_until(deadline), true, false, silence});
  if (reply.outcome().kind() == OutcomeKind::timed_out) {
    return missing_stepper(target, discovery_.slowest_stepper(target.key));
  }
  if (!reply) return reply;
  if (reply->reason == msg::Reason::wrong_incarnation) {
    return Outcome::lost(restarted_text(target));
  }
  note_reply(target.key, step, *reply);
  if (!is_accepted(*reply)) return refusal_of(target, *reply, step_of(target));
  return reply;
}

Result<std::uint64_t> BenchClocks::end_step(const Target& target, PendingStep step,
                                            Clock::time_point deadline) {
  while (true) {
    const auto reply = conclude_step(target, step, deadline, Silence::ends_call);
    if (!reply) return reply.outcome();
    if (reply->reason == msg::Reason::none) return reply->tick;
    if (Clock::now() >= deadline) return missing_stepper(target, reply->missing_stepper);
    // Granted ticks stay granted: repeat with 0 ticks until the others have granted theirs.
    const auto again = begin_step_to(target, 0);
    if (!again) return again.outcome();
    step = *again;
  }
}

Outcome BenchClocks::missing_stepper(const Target& target, std::uint64_t session) const {
  const std::uint32_t joined = discovery_.steppers(target.key);
  if (session == 0 && joined != 0) {
    return Outcome::timed_out(name_of(target) + " waits for more steppers: " +
                              counted(joined, "program has", "programs have") +
                              " joined its clock");
  }
  if (session == 0 || session == session_)
    return Outcome::timed_out(name_of(target) + " did not answer");
  return Outcome::timed_out(name_of(target) + " waits for stepper " + session_text(session) +
                            ", which has not granted the next tick");
}

// ---- steps -----------------------------------------------------------------------------------

Result<RequestAnswer> BenchClocks::step_as_stepper(const Target& target, const Grant& grant,
                                                   const msg::Request& request,
                                                   milliseconds patience, Silence silence) {
  const std::uint64_t aim = grant.reached + request.ticks;
  std::uint64_t reached = grant.reached;
  auto deadline = Clock::now() + patience;
  while (true) {
    const auto step = begin_step_to(target, aim, request.axes);
    if (!step) return step.outcome();
    auto reply = conclude_step(target, *step, deadline, silence);
    // A call that only observes accepts the state as it is.
    if (!reply || reply->reason == msg::Reason::none || request.ticks == 0) return reply;
    // Passing time shows that the other steppers are alive: restart the patience.
    if (reply->tick > reached) deadline = Clock::now() + patience;
    reached = reply->tick;
    if (Clock::now() >= deadline) return missing_stepper(target, reply->missing_stepper);
  }
}

Result<RequestAnswer> BenchClocks::step_once(const Target& target, msg::Request request,
                                             milliseconds patience, Silence silence) {
  // A call that only observes does not wait.
  Result<StepLock> steps = StepLock();
  if (request.ticks > 0) steps = lock_steps(target, Clock::now() + patience);
  if (!steps) return steps.outcome();
  if (const auto grant = grant_of(target.key)) {
    return step_as_stepper(target, *grant, request, patience, silence);
  }
  request.last_sequence = held_axes_.last_sequence(target.key);
  return exchange_.request(target, std::move(request), step_of(target), silence);
}

Result<Observation> BenchClocks::step(const Target& target, std::uint64_t ticks,
                                      std::span<const std::uint16_t> axes, milliseconds patience,
                                      Silence silence) {
  Observation observation;
  if (Outcome stepped = step(target, ticks, axes, patience, silence, observation); !stepped) {
    return stepped;
  }
  return observation;
}

Outcome BenchClocks::step(const Target& target, std::uint64_t ticks,
                          std::span<const std::uint16_t> axes, milliseconds patience,
                          Silence silence, Observation& sample) {
  std::uint64_t left = ticks;
  std::vector<AxisSnapshot> earlier;  // kept apart from `sample`, because a later reply may fail
  bool is_last = false;
  do {
    if (left != 0 && wakeup_.is_interrupted()) return Outcome::failed("interrupted");
    msg::Request request = next_request(left, axes);
    const std::size_t wanted = request.axes.size();
    auto reply = step_once(target, std::move(request), patience, silence);
    if (!reply) return reply.outcome();
    if (reply->axes.size() != wanted) {
      return Outcome::failed(name_of(target) + " did not send the status of the requested axes");
    }
    is_last = left == 0 && axes.empty();
    fill_samples(*reply, earlier.size(), is_last ? sample.axes : earlier);
    if (wanted != 0) exchange_.reuse(*reply);
    if (is_last) {
      std::ranges::copy(earlier, sample.axes.begin());
      sample = {.tick = reply->tick, .axes = std::move(sample.axes)};
    }
  } while (!is_last);
  return {};
}

}  // namespace vdrive::client
