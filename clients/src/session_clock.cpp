// SPDX-License-Identifier: Apache-2.0
// The clock of a bench: steps, joining it, its rate.
#include "session_core.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::client {
namespace {

using Clock = Directory::Clock;
using std::chrono::milliseconds;

// One request steps at most this far, so that an interrupt or a lost service is noticed.
constexpr std::uint64_t kTicksPerRequest = 2000;

constexpr std::size_t kAxesPerRequest = msg::MAX_AXES_PER_FRAME;

constexpr SessionCore::Patience kFarewell{milliseconds(500), false};

/// Wall time until the deadline, which may have passed.
milliseconds left_until(Clock::time_point deadline) {
  return std::max(milliseconds(0), std::chrono::ceil<milliseconds>(deadline - Clock::now()));
}

std::string step_of(const Target& target) {
  return "step of " + name_of(target);
}

}  // namespace

bool SessionCore::is_paused(const Target& target) {
  const std::scoped_lock lock(mutex_);
  return directory_.is_paused(target.key, {});
}

Result<std::uint64_t> SessionCore::set_rate(const Target& target, double rate) {
  msg::Request request;
  request.kind(msg::REQUEST_SET_RATE);
  request.rate(rate);
  const auto reply = this->request(target, std::move(request), "rate of " + name_of(target));
  if (!reply) return reply.outcome();
  const std::scoped_lock lock(mutex_);
  directory_.set_rate(target.key, rate);
  return reply->tick();
}

Outcome SessionCore::check_presence(const Target& target) {
  const std::scoped_lock lock(mutex_);
  const auto now = Clock::now();
  const bool is_there = directory_.is_alive(target.key, options_.silence, now) &&
                        !directory_.is_restarted(target.key, now);
  return is_there ? Outcome() : gone(target);
}

// ---- steppers ---------------------------------------------------------------------------------

Result<std::uint64_t> SessionCore::join_clock(const Target& target) {
  {
    const std::scoped_lock lock(mutex_);
    if (grants_.contains(target.key)) {
      return Outcome::failed("this session has joined the clock of " + name_of(target) +
                             " already");
    }
  }
  msg::Request request;
  request.kind(msg::REQUEST_JOIN_CLOCK);
  const auto reply =
      this->request(target, std::move(request), "joining the clock of " + name_of(target));
  if (!reply) return reply.outcome();
  const std::scoped_lock lock(mutex_);
  grants_[target.key] = {.granted = reply->tick(), .reached = reply->tick()};
  return reply->tick();
}

void SessionCore::leave_clock(const Target& target) {
  {
    const std::scoped_lock lock(mutex_);
    grants_.erase(target.key);
  }
  msg::Request request;
  request.kind(msg::REQUEST_LEAVE_CLOCK);
  const auto number = send_request(target, std::move(request));
  if (number) (void)await_reply(target, *number, kFarewell);  // it may be gone
}

std::optional<SessionCore::Grant> SessionCore::grant_of(const BenchKey& key) {
  const std::scoped_lock lock(mutex_);
  const auto grant = grants_.find(key);
  return grant == grants_.end() ? std::nullopt : std::optional(grant->second);
}

Result<SessionCore::Stepping> SessionCore::begin_step_to(const Target& target, std::uint64_t tick,
                                                         msg::Request request) {
  Stepping stepping;
  {
    const std::scoped_lock lock(mutex_);
    const auto grant = grants_.find(target.key);
    if (grant == grants_.end()) {
      return Outcome::refused(msg::REASON_NOT_A_STEPPER, step_of(target) + " refused");
    }
    const std::uint64_t granted = grant->second.granted;
    stepping.ticks = tick > granted ? tick - granted : 0;
    grant->second.granted += stepping.ticks;
  }
  request.kind(msg::REQUEST_STEP);
  request.ticks(stepping.ticks);
  request.last_sequence(last_sequence(target.key));
  const auto number = send_request(target, std::move(request));
  if (!number) return number.outcome();
  stepping.request = *number;
  return stepping;
}

/// What a step came to: reached, or REASON_MISSING_STEPPER in the reply.
Result<msg::Reply> SessionCore::conclude_step(const Target& target, const Stepping& stepping,
                                              Clock::time_point deadline) {
  auto reply = await_reply(target, stepping.request, {left_until(deadline), true});
  if (reply.outcome().kind() == OutcomeKind::timed_out) {
    std::unique_lock lock(mutex_);
    const std::uint64_t slowest = directory_.slowest_stepper(target.key);
    lock.unlock();
    return missing_stepper(target, slowest);
  }
  if (!reply) return reply;
  const std::uint32_t reason = reply->reason();
  if (reason == msg::REASON_WRONG_INCARNATION) return Outcome::lost(restarted_text(target));
  const bool is_fine = reason == msg::REASON_NONE || reason == msg::REASON_MISSING_STEPPER;
  const std::scoped_lock lock(mutex_);
  if (const auto grant = grants_.find(target.key); grant != grants_.end()) {
    if (is_fine) {
      grant->second.reached = std::max(grant->second.reached, reply->tick());
    } else if (reason == msg::REASON_NOT_A_STEPPER) {  // taken off the clock
      grants_.erase(grant);
    } else {
      grant->second.granted -= stepping.ticks;
    }
  }
  if (!is_fine) return refusal_of(target, *reply, step_of(target));
  return reply;
}

Result<std::uint64_t> SessionCore::end_step(const Target& target, Stepping stepping,
                                            Clock::time_point deadline) {
  while (true) {
    const auto reply = conclude_step(target, stepping, deadline);
    if (!reply) return reply.outcome();
    if (reply->reason() == msg::REASON_NONE) return reply->tick();
    if (Clock::now() >= deadline) return missing_stepper(target, reply->missing_stepper());
    const auto again = begin_step_to(target, 0, {});
    if (!again) return again.outcome();
    stepping = *again;
  }
}

Outcome SessionCore::missing_stepper(const Target& target, std::uint64_t session) const {
  if (session == 0 || session == id_)
    return Outcome::timed_out(name_of(target) + " did not answer");
  return Outcome::timed_out(name_of(target) + " waits for stepper " + session_text(session) +
                            ", which has not granted the next tick");
}

Result<msg::Reply> SessionCore::step_as_stepper(const Target& target, const Grant& grant,
                                                const msg::Request& request,
                                                milliseconds patience) {
  const std::uint64_t aim = grant.reached + request.ticks();
  std::uint64_t reached = grant.reached;
  auto deadline = Clock::now() + patience;
  while (true) {
    const auto stepping = begin_step_to(target, aim, request);
    if (!stepping) return stepping.outcome();
    auto reply = conclude_step(target, *stepping, deadline);
    // Who only looks is content with what it sees.
    if (!reply || reply->reason() == msg::REASON_NONE || request.ticks() == 0) return reply;
    if (reply->tick() > reached) deadline = Clock::now() + patience;
    reached = reply->tick();
    if (Clock::now() >= deadline) return missing_stepper(target, reply->missing_stepper());
  }
}

Result<msg::Reply> SessionCore::step_once(const Target& target, msg::Request request,
                                          milliseconds patience) {
  if (const auto grant = grant_of(target.key)) {
    return step_as_stepper(target, *grant, request, patience);
  }
  request.last_sequence(last_sequence(target.key));
  return this->request(target, std::move(request), step_of(target));
}

Result<Observation> SessionCore::step(const Target& target, std::uint64_t ticks,
                                      std::span<const std::uint16_t> axes, milliseconds patience) {
  std::uint64_t left = ticks;
  std::size_t shown = 0;
  Observation observation;
  do {
    if (left != 0 && is_interrupted()) return Outcome::failed("interrupted");
    msg::Request request;
    request.kind(msg::REQUEST_STEP);
    request.ticks(std::min(left, kTicksPerRequest));
    left -= request.ticks();
    if (left == 0) {  // the axes are shown once time has passed
      const std::size_t count = std::min(axes.size() - shown, kAxesPerRequest);
      request.axes().assign(axes.begin() + static_cast<std::ptrdiff_t>(shown),
                            axes.begin() + static_cast<std::ptrdiff_t>(shown + count));
      shown += count;
    }
    const std::size_t wanted = request.axes().size();
    const auto reply = step_once(target, std::move(request), patience);
    if (!reply) return reply.outcome();
    if (reply->statuses().size() != wanted) {
      return Outcome::failed(name_of(target) + " did not send the status of the requested axes");
    }
    observation.tick = reply->tick();
    for (const msg::AxisStatus& status : reply->statuses()) {
      observation.axes.push_back(snapshot_of(status));
    }
  } while (left != 0 || shown < axes.size());
  return observation;
}

}  // namespace vdrive::client
