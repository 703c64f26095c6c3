// SPDX-License-Identifier: Apache-2.0
#include "session/session_core.hpp"
#include "vdrive/client/session.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

namespace vdrive::client {

struct Follower::State {
  std::shared_ptr<SessionCore> core;
  Target target;
  std::vector<std::uint16_t> axes;
  Pace pace = Pace::drive;
  std::shared_ptr<StatusFeed> feed;  ///< none if each sample is a step

  Lateness lateness;

  void note_seen(const Observation& sample) {
    core->held_axes.note_seen(target.key, sample.axes);
    ++lateness.samples;
    if (feed) note_lateness(sample.tick);
  }

  void note_lateness(std::uint64_t tick) {
    // A frame reaches its feed slightly before it counts as a sign of life, so `tick` may be the
    // newer one.
    const std::uint64_t newest = std::max(core->discovery.tick(target.key), tick);
    const std::uint64_t behind = newest - tick;
    if (behind >= target.status_every_ticks) ++lateness.late;
    lateness.last = static_cast<std::int64_t>(behind) * std::chrono::nanoseconds(target.period);
    lateness.longest = std::max(lateness.longest, lateness.last);
  }
};

Follower::Follower(std::unique_ptr<State> state) : state_(std::move(state)) {}

Follower::~Follower() = default;
Follower::Follower(Follower&&) noexcept = default;
Follower& Follower::operator=(Follower&&) noexcept = default;

Result<Observation> Follower::next(std::chrono::milliseconds patience) {
  Observation sample;
  if (Outcome seen = next(patience, sample); !seen) return seen;
  return sample;
}

Outcome Follower::next(std::chrono::milliseconds patience, Observation& sample) {
  if (Outcome here = state_->core->discovery.check_process(); !here) return here;
  state_->core->failure.rethrow();
  if (!state_->feed) {
    Outcome stepped = state_->core->clocks.step(state_->target, 1, state_->axes, patience,
                                                Silence::is_bridged, sample);
    if (stepped) state_->note_seen(sample);
    return stepped;
  }
  Outcome seen = state_->core->stream.next(
      state_->target, *state_->feed,
      {patience, true, state_->pace == Pace::drive, Silence::is_bridged}, sample);
  if (seen) state_->note_seen(sample);
  return seen;
}

bool Follower::has_next() const {
  if (!state_->core->discovery.check_process()) return true;  // forked: next() reports that
  if (state_->feed) return state_->core->stream.has_next(*state_->feed);
  return state_->core->clocks.steps_at_once(state_->target, 1);
}

Lateness Follower::lateness() const noexcept {
  return state_->lateness;
}

Follower SessionCore::follow(const Target& target, std::vector<std::uint16_t> axes, Pace pace) {
  auto state = std::make_unique<Follower::State>();
  state->core = shared_from_this();
  state->target = target;
  state->pace = pace;
  if (pace == Pace::observe || !target.steps()) {
    state->feed =
        stream.open_feed(target, axes, observer.first_tick_of_stream(target, axes.front()));
  }
  state->axes = std::move(axes);
  return Follower(std::move(state));
}

}  // namespace vdrive::client
