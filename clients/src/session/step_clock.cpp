// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/step_clock.hpp"

#include "session/session_core.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::nanoseconds;

static_assert(StepClock::kMostSteppers == msg::MAX_STEPPERS);

// A round grants each bench at most this many ticks, then waits for all benches.
constexpr std::uint64_t kTicksPerRound = 2000;

struct Member {
  Target target;
  std::uint64_t begin = 0;  ///< tick at which the unfinished step began
  std::uint64_t aim = 0;    ///< tick at which it ends
};

std::string period_of(const Member& member) {
  return name_of(member.target) + " has ticks of " + std::to_string(member.target.period.count()) +
         " us";
}

}  // namespace

struct StepClock::State {
  std::shared_ptr<SessionCore> core;
  std::vector<Member> members;
  std::atomic<nanoseconds::rep> now = 0;
  TurnMutex steps;             ///< one step at a time; guards the ticks of the members
  bool is_unfinished = false;  ///< guarded by `steps`

  explicit State(std::shared_ptr<SessionCore> session) : core(std::move(session)) {}

  ~State() {
    if (!core->discovery.check_process()) return;
    for (const Member& member : members) core->clocks.leave(member.target);
  }

  State(const State&) = delete;
  State& operator=(const State&) = delete;

  Outcome add(std::uint32_t bench, std::uint32_t steppers);
  void begin_step();
  [[nodiscard]] std::uint64_t reached_by(const Member& member) const;
  [[nodiscard]] std::string late_members() const;
  Outcome round(std::uint64_t ticks, Clock::time_point deadline);
  Outcome step_to_aims(Clock::time_point deadline);
  Result<std::vector<std::uint64_t>> run(nanoseconds duration, Clock::time_point deadline);
};

/// Joins the clock of the bench.
Outcome StepClock::State::add(std::uint32_t bench, std::uint32_t steppers) {
  const auto target = core->links.connect(bench);
  if (!target) return target.outcome();
  if (!target->steps()) {
    return Outcome::refused(wire::number(msg::Reason::wrong_clock_mode),
                            name_of(*target) + " runs in " +
                                std::string(to_string(target->clock_mode)) +
                                ", a common clock needs lockstep");
  }
  const auto tick = core->clocks.join(*target, steppers);
  if (!tick) return tick.outcome();
  members.push_back({.target = *target});
  return {};
}

/// A step that timed out continues from where it began; a new one starts from the present tick of
/// each bench.
void StepClock::State::begin_step() {
  for (Member& member : members) {
    const auto grant = core->clocks.grant_of(member.target.key);
    if (!is_unfinished && grant) member.begin = grant->reached;
  }
  is_unfinished = true;
}

std::uint64_t StepClock::State::reached_by(const Member& member) const {
  const auto grant = core->clocks.grant_of(member.target.key);
  return grant ? grant->reached : member.begin;
}

/// @return the benches that have not reached their aim, and their ticks; empty if all have.
std::string StepClock::State::late_members() const {
  std::string late;
  for (const Member& member : members) {
    const std::uint64_t reached = reached_by(member);
    if (reached >= member.aim) continue;
    late += (late.empty() ? "" : "; ") + name_of(member.target) + " is at tick " +
            std::to_string(reached) + " of " + std::to_string(member.aim);
  }
  return late;
}

/// Grants up to `ticks` more towards the aim on all benches, then waits for all of them.
Outcome StepClock::State::round(std::uint64_t ticks, Clock::time_point deadline) {
  std::vector<PendingStep> steppings;
  for (const Member& member : members) {
    const std::uint64_t next = std::min(member.aim, reached_by(member) + ticks);
    const auto stepping = core->clocks.begin_step_to(member.target, next);
    if (!stepping) return stepping.outcome();
    steppings.push_back(*stepping);
  }
  std::string late;
  Outcome failure;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Outcome ended =
        core->clocks.end_step(members[i].target, steppings[i], deadline).outcome();
    if (ended.kind() == OutcomeKind::timed_out) {
      late += (late.empty() ? "" : "; ") + ended.message();
    } else if (!ended && failure) {
      failure = ended;
    }
  }
  return late.empty() || !failure ? failure : Outcome::timed_out(late);
}

Outcome StepClock::State::step_to_aims(Clock::time_point deadline) {
  while (true) {
    if (Outcome passed = round(kTicksPerRound, deadline); !passed) return passed;
    const std::string late = late_members();
    if (late.empty()) return {};
    // Checked here, because a bench in this process may answer so fast that no wait is interrupted.
    if (core->wakeup.is_interrupted()) return Outcome::failed("interrupted");
    if (Clock::now() >= deadline) return Outcome::timed_out(late);
  }
}

Result<std::vector<std::uint64_t>> StepClock::State::run(nanoseconds duration,
                                                         Clock::time_point deadline) {
  if (Outcome here = core->discovery.check_process(); !here) return here;
  core->failure.rethrow();
  for (const Member& member : members) {
    if (Outcome there = core->discovery.check_presence(member.target); !there) return there;
  }
  const StepLock lock(steps, deadline);
  if (!lock) {
    return Outcome::timed_out("another thread steps this clock, and its step has not ended");
  }
  // Locked, because other calls of the session step the same clocks.
  std::vector<StepLock> clocks;
  for (const Member& member : members) {
    auto its = core->clocks.lock_steps(member.target, deadline);
    if (!its) return its.outcome();
    clocks.push_back(*std::move(its));
  }
  begin_step();
  for (Member& member : members) {
    member.aim = member.begin + ticks_of(duration, member.target.period);
  }
  if (Outcome passed = step_to_aims(deadline); !passed) return passed;
  std::vector<std::uint64_t> reached;
  for (const Member& member : members) {
    const auto grant = core->clocks.grant_of(member.target.key);
    reached.push_back(grant ? grant->reached : member.aim);
  }
  is_unfinished = false;
  now += duration.count();
  return reached;
}

StepClock::StepClock(std::unique_ptr<State> state) : state_(std::move(state)) {}

StepClock::StepClock(StepClock&&) noexcept = default;
StepClock& StepClock::operator=(StepClock&&) noexcept = default;

StepClock::~StepClock() = default;

Result<StepClock> StepClock::join(Session& session, std::span<const std::uint32_t> benches,
                                  std::uint32_t steppers) {
  if (benches.empty()) return Outcome::not_found("a common clock needs a bench");
  StepClock clock(std::make_unique<State>(session.core_));
  for (const std::uint32_t bench : benches) {
    if (Outcome added = clock.state_->add(bench, steppers); !added) return added;
  }
  return clock;
}

Result<std::vector<std::uint64_t>> StepClock::step(std::uint64_t ticks,
                                                   std::chrono::milliseconds patience) {
  const Member& first = state_->members.front();
  for (const Member& other : state_->members) {
    if (other.target.period != first.target.period) {
      return Outcome::failed(period_of(first) + " and " + period_of(other) +
                             ": use step_for with a drive time");
    }
  }
  const nanoseconds period = first.target.period;
  const auto most = static_cast<std::uint64_t>(nanoseconds::max() / period);
  if (ticks > most) {
    return Outcome::failed(std::to_string(ticks) + " ticks of " +
                           std::to_string(first.target.period.count()) +
                           " us exceed the range of a clock: at most " + std::to_string(most));
  }
  return state_->run(period * static_cast<std::int64_t>(ticks), Clock::now() + patience);
}

Result<std::vector<std::uint64_t>> StepClock::step_for(nanoseconds duration,
                                                       std::chrono::milliseconds patience) {
  for (const Member& member : state_->members) {
    if (duration.count() < 0 || duration % nanoseconds(member.target.period) != nanoseconds(0)) {
      return Outcome::failed(period_of(member) + ", and " + std::to_string(duration.count()) +
                             " ns is not a multiple of that");
    }
  }
  return state_->run(duration, Clock::now() + patience);
}

nanoseconds StepClock::now() const noexcept {
  return nanoseconds(state_->now);
}

}  // namespace vdrive::client
