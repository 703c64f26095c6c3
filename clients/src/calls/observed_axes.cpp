// SPDX-License-Identifier: Apache-2.0
#include "calls/observed_axes.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// Longest wait for a sample of a stream, in wall time, before the reasons to give up are checked.
constexpr milliseconds kSamplePatience{500};

// Benches whose clocks differ by more than this do not act in common ticks.
constexpr milliseconds kSynchronised{100};

std::string axes_of(const GroupLayout::Bench& bench) {
  std::string text;
  for (std::size_t i = 0; i < std::min(bench.axes.size(), kMostNamed); ++i) {
    text += (i == 0 ? "axis " : ", axis ") + to_string(AxisId{bench.number, bench.axes[i]});
  }
  if (bench.axes.size() > kMostNamed) {
    text += " and " + std::to_string(bench.axes.size() - kMostNamed) + " more";
  }
  return text;
}

}  // namespace

GroupLayout layout_of(std::span<const AxisId> axes) {
  GroupLayout layout{.axes = {axes.begin(), axes.end()}, .benches = {}};
  for (std::size_t place = 0; place < axes.size(); ++place) {
    auto bench = std::ranges::find(layout.benches, axes[place].bench, &GroupLayout::Bench::number);
    if (bench == layout.benches.end()) {
      bench = layout.benches.insert(bench, {.number = axes[place].bench, .axes = {}, .places = {}});
    }
    bench->axes.push_back(axes[place].axis);
    bench->places.push_back(place);
  }
  return layout;
}

ObservedAxes::ObservedAxes(std::shared_ptr<SessionCore> core, GroupLayout layout, Caller caller,
                           Progress progress)
    : core_(std::move(core)),
      layout_(std::make_shared<const GroupLayout>(std::move(layout))),
      caller_(caller),
      progress_(std::move(progress)),
      snapshots_(layout_->axes.size()) {}

Outcome ObservedAxes::open() {
  if (std::exchange(is_open_, true)) return {};
  for (const GroupLayout::Bench& bench : layout_->benches) {
    auto target = core_->links.connect(bench.number);
    if (!target) return target.outcome();
    BenchPart& part = parts_.emplace_back();
    part.bench = &bench;
    part.target = *target;
    if (!part.target.steps()) part.feed = core_->stream.open_feed(part.target, bench.axes);
  }
  return {};
}

Outcome ObservedAxes::connect() {
  if (Outcome opened = open(); !opened) return opened;
  if (Outcome comparable = compare_clocks(); !comparable) return comparable;
  return observe_first();
}

Outcome ObservedAxes::compare_clocks() const {
  const Target& first = parts_.front().target;
  for (const BenchPart& part : parts_) {
    const Target& other = part.target;
    const std::string pair = name_of(first) + " and " + name_of(other);
    if (other.clock_mode != first.clock_mode) {
      return Outcome::refused(wire::number(msg::Reason::wrong_clock_mode),
                              pair + " have different clock modes and cannot form a group");
    }
    if (other.period != first.period) {
      return Outcome::refused(wire::number(msg::Reason::wrong_clock_mode),
                              pair + " have different periods and cannot form a group");
    }
    const bool shared = other.steps() || (other.clock_mode == ClockMode::realtime &&
                                          other.rate == 1.0 && first.rate == 1.0);
    if (parts_.size() > 1 && !shared) {
      return Outcome::refused(
          wire::number(msg::Reason::wrong_clock_mode),
          pair + " do not share a clock: a group needs lock-step, or real time at rate 1");
    }
  }
  return {};
}

/// A group waits for a bench that is paused when the call starts.
Outcome ObservedAxes::first_sample(BenchPart& part) {
  const bool is_running = part.feed && !part.target.is_paused;
  if (!is_running) return note(part, core_->observer.observe(part.target, part.bench->axes));
  if (caller_ == Caller::group) return next(part);
  return note(part, core_->observer.observe(part.target, part.bench->axes, *part.feed));
}

/// Observes the first sample of each bench, then the first tick that all of them show.
Outcome ObservedAxes::observe_first() {
  for (BenchPart& part : parts_) {
    if (Outcome seen = first_sample(part); !seen) return seen;
  }
  if (!steps()) {
    if (Outcome shared = await_common_ticks(); !shared) return shared;
  }
  if (Outcome aligned = align(); !aligned) return aligned;
  publish();
  return {};
}

/// A bench whose samples are late, for example after a link failure, catches up; one whose clock
/// differs never does.
Outcome ObservedAxes::await_common_ticks() {
  const std::uint64_t apart = ticks_of(kSynchronised, period());
  const auto tick_of = [](const BenchPart& part) {
    return part.seen.tick;
  };
  const auto give_up = std::chrono::steady_clock::now() + core_->discovery.silence();
  while (true) {
    const auto [least, most] = std::ranges::minmax_element(parts_, {}, tick_of);
    if (most->seen.tick - least->seen.tick <= apart) return {};
    if (std::chrono::steady_clock::now() > give_up) {
      return Outcome::refused(
          wire::number(msg::Reason::wrong_clock_mode),
          name_of(least->target) + " and " + name_of(most->target) +
              " have different tick numbers: their clocks are not synchronised");
    }
    if (Outcome seen = next(*least); !seen) return seen;
    // While the call waits for one bench, it must not fall behind on the others.
    for (BenchPart& part : parts_) {
      if (Outcome seen = catch_up(part); !seen) return seen;
    }
  }
}

/// Takes the samples that have arrived, without waiting.
Outcome ObservedAxes::catch_up(BenchPart& part) {
  while (true) {
    auto sample = core_->stream.next(part.target, *part.feed, {milliseconds(0), true});
    if (sample.outcome().kind() == OutcomeKind::timed_out) return {};
    if (Outcome noted = note(part, std::move(sample)); !noted) return noted;
  }
}

/// Waits for the next sample of a stream: for a group until there is one, for an axis for a limited
/// time.
Outcome ObservedAxes::next(BenchPart& part) {
  const bool is_axis = caller_ == Caller::axis;
  while (true) {
    auto sample = core_->stream.next(
        part.target, *part.feed,
        {.timeout = kSamplePatience, .may_interrupt = true, .needs_drive_time = is_axis});
    // Checked even while samples are waiting: if the caller's condition is slower than the stream,
    // samples are always waiting.
    if (stop_.stop_requested() || core_->wakeup.is_interrupted()) {
      return Outcome::failed("interrupted");
    }
    if (is_axis || sample.outcome().kind() != OutcomeKind::timed_out) {
      return note(part, std::move(sample));
    }
  }
}

Outcome ObservedAxes::advance(std::uint64_t ticks, milliseconds patience) {
  if (Outcome there = require_a_bench(); !there) return there;
  Outcome result;
  for (BenchPart& part : parts_) {
    if (part.is_lost()) continue;
    Outcome seen =
        part.feed ? next(part)
                  : note(part, core_->clocks.step(part.target, ticks, part.bench->axes, patience));
    if (!seen && !part.is_lost()) return seen;
    if (!seen && result) result = std::move(seen);
  }
  if (!result) return result;
  if (Outcome aligned = align(); !aligned) return aligned;
  publish();
  return {};
}

Outcome ObservedAxes::refresh() {
  if (Outcome there = require_a_bench(); !there) return there;
  for (BenchPart& part : parts_) {
    if (part.is_lost()) continue;
    Outcome seen = part.feed ? catch_up(part)
                             : note(part, core_->clocks.step(part.target, 0, part.bench->axes));
    if (!seen) return seen;
  }
  if (Outcome aligned = align(); !aligned) return aligned;
  publish();
  return {};
}

Outcome ObservedAxes::look_again() {
  for (BenchPart& part : parts_) {
    if (part.is_lost() || !part.feed || core_->discovery.is_paused(part.target.key)) continue;
    const auto since = core_->observer.completed_tick(part.target, part.bench->axes.front());
    if (!since) return note_lost(part, since.outcome());
    while (part.seen.tick < *since) {
      if (Outcome seen = next(part); !seen) return seen;
    }
  }
  if (Outcome aligned = align(); !aligned) return aligned;
  publish();
  return {};
}

/// Samples of a stream can be missing: continues until all benches show the same tick.
Outcome ObservedAxes::align() {
  std::uint64_t newest = 0;
  bool moved = !steps();
  while (moved) {
    moved = false;
    for (const BenchPart& part : parts_) newest = std::max(newest, part.seen.tick);
    for (BenchPart& part : parts_) {
      while (!part.is_lost() && part.seen.tick < newest) {
        if (Outcome seen = next(part); !seen) return seen;
        moved = true;
      }
    }
  }
  return {};
}

Outcome ObservedAxes::note_lost(BenchPart& part, Outcome outcome) const {
  if (outcome.kind() != OutcomeKind::lost) return outcome;
  part.loss = caller_ == Caller::axis
                  ? std::move(outcome)
                  : Outcome::lost(axes_of(*part.bench) + ": " + outcome.message());
  return part.loss;
}

/// A call must not continue without its only bench: it would wait for ticks that never arrive.
Outcome ObservedAxes::require_a_bench() const {
  const bool are_all_lost = std::ranges::all_of(parts_, &BenchPart::is_lost);
  return are_all_lost && !parts_.empty() ? parts_.front().loss : Outcome();
}

Outcome ObservedAxes::note(BenchPart& part, Result<Observation> sample) const {
  if (!sample) return note_lost(part, sample.outcome());
  part.seen = std::move(*sample);
  part.skipped += part.seen.skipped;
  core_->held_axes.note_seen(part.target.key, part.seen.axes);
  return {};
}

void ObservedAxes::publish() {
  for (const BenchPart& part : parts_) {
    if (part.is_lost()) continue;
    for (std::size_t i = 0; i < part.bench->places.size(); ++i) {
      AxisSnapshot& axis = snapshots_[part.bench->places[i]];
      axis = part.seen.axes[i];
      axis.tick = part.seen.tick;
      axis.skipped = part.skipped;
    }
  }
  const auto present = std::ranges::find(parts_, false, &BenchPart::is_lost);
  if (present != parts_.end()) {
    tick_ = present->seen.tick;
    driven_tick_ = tick_ - present->skipped;
  }
  if (progress_) progress_(tick_, snapshots_);
}

bool ObservedAxes::is_present(const AxisSnapshot& axis) const {
  return std::ranges::any_of(parts_, [&axis](const BenchPart& part) {
    return part.bench->number == axis.id.bench && !part.is_lost();
  });
}

Result<std::uint64_t> ObservedAxes::newest_tick() {
  std::uint64_t newest = tick_;
  for (const BenchPart& part : parts_) {
    const auto present = core_->observer.present_tick(part.target);
    if (!present) return present.outcome();
    newest = std::max(newest, *present);
  }
  return newest;
}

// ---- lost control ----------------------------------------------------------------------------

namespace {

// A sample sent before the change may still show the previous owner.
constexpr int kMostSamples = 5;

bool is_loss(const Outcome& outcome) {
  const bool is_for_a_loss = outcome.code() == wire::number(msg::Reason::stale_epoch) ||
                             outcome.code() == wire::number(msg::Reason::not_owner);
  return outcome.kind() == OutcomeKind::refused && is_for_a_loss && outcome.owner() == nullptr;
}

/// Adds the axes of one bench that other sessions hold.
void add_owners(SessionCore& core, const Target& target, std::span<const std::uint16_t> axes,
                std::map<AxisId, AxisOwner>& owners) {
  for (int sample = 0; sample < kMostSamples; ++sample) {
    const auto seen = core.observer.observe(target, axes);
    if (!seen) return;
    bool is_old = false;
    for (const AxisSnapshot& axis : seen->axes) {
      if (axis.owner_session == core.id) is_old = true;
      if (axis.owner_session == 0 || axis.owner_session == core.id) continue;
      owners[axis.id] = {.axis = axis.id, .session = axis.owner_session};
    }
    if (!owners.empty() || !is_old) return;
  }
}

/// @return the other sessions that hold these axes now.
std::map<AxisId, AxisOwner> owners_of(SessionCore& core, std::span<const AxisId> axes) {
  std::map<std::uint32_t, std::vector<std::uint16_t>> by_bench;
  for (const AxisId& axis : axes) by_bench[axis.bench].push_back(axis.axis);
  std::map<AxisId, AxisOwner> owners;
  for (const auto& [bench, numbers] : by_bench) {
    const auto target = core.discovery.present_target(bench);
    if (!target) continue;
    std::map<AxisId, AxisOwner> some;
    add_owners(core, *target, numbers, some);
    owners.merge(some);
  }
  for (auto& [axis, owner] : owners) owner.name = core.names.find(axis.bench, owner.session);
  return owners;
}

}  // namespace

Outcome explain_loss(SessionCore& core, Outcome outcome, std::span<const AxisId> axes) {
  if (const AxisOwner* const owner = outcome.owner(); owner != nullptr && !owner->name) {
    AxisOwner known = *owner;
    known.name = core.names.find(known.axis.bench, known.session);
    return outcome.with_owner(std::move(known));
  }
  if (!is_loss(outcome)) return outcome;
  const auto owners = owners_of(core, axes);
  return owners.empty() ? outcome : outcome.with_owner(owners.begin()->second);
}

void explain_losses(SessionCore& core, std::span<Outcome> outcomes, std::span<const AxisId> axes) {
  std::vector<AxisId> lost;
  for (std::size_t place = 0; place < outcomes.size(); ++place) {
    if (is_loss(outcomes[place])) lost.push_back(axes[place]);
  }
  if (lost.empty()) return;
  const auto owners = owners_of(core, lost);
  for (std::size_t place = 0; place < outcomes.size(); ++place) {
    const auto owner = owners.find(axes[place]);
    if (owner == owners.end() || !is_loss(outcomes[place])) continue;
    outcomes[place] = outcomes[place].with_owner(owner->second);
  }
}

}  // namespace vdrive::client
