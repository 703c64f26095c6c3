// SPDX-License-Identifier: Apache-2.0
#include "bridge/stepped_bench.hpp"

#include "bench_follower.hpp"
#include "bridge/drive_access.hpp"

#include <array>
#include <utility>

namespace vdrive::canopen {
namespace {

std::string microseconds_text(std::chrono::microseconds time) {
  return std::to_string(time.count()) + " us";
}

}  // namespace

SteppedBench::SteppedBench(const BusParts& parts, const client::BenchInfo& info,
                           std::span<const NodePlace> places, std::string label,
                           std::chrono::microseconds period)
    : parts_(parts),
      bench_(info.number),
      ids_(bridge::ids_of(info)),
      label_(std::move(label)),
      ticks_(static_cast<std::uint64_t>(period / info.period)),
      tick_period_(info.period),
      control_(parts.session, parts.reports, ids_, control_options(label_)),
      nodes_(parts.bus, parts.store, *this, places,
             {.session = parts.session.id(),
              .sync_period = static_cast<std::uint32_t>(period.count()),
              .software_version = VDRIVE_VERSION}) {}

SteppedBench::~SteppedBench() = default;

std::optional<std::string> SteppedBench::refusal_of(const client::BenchInfo& info,
                                                    std::chrono::microseconds period) {
  if (info.clock_mode != client::ClockMode::lockstep) {
    return "its clock is " + std::string(to_string(info.clock_mode)) +
           ": --sync-steps needs lockstep";
  }
  if (period % info.period != std::chrono::microseconds{0}) {
    return "--sync-steps " + microseconds_text(period) + " is not a multiple of its tick, " +
           microseconds_text(info.period);
  }
  return std::nullopt;
}

// ---- start and end of the bench --------------------------------------------------------------

void SteppedBench::poll(const client::BenchInfo* present) {
  const bool is_there = present != nullptr && present->incarnation == incarnation_;
  if (nodes_.is_running() && !is_there) close("has ended");
  if (present == nullptr || nodes_.is_running()) return;
  const client::Outcome opened = open();
  if (opened) {
    incarnation_ = present->incarnation;
  } else {
    note_failure(opened, "its clock");
    // Other steppers would wait for nodes that are absent.
    follower_.reset();
    clock_.reset();
  }
}

client::Outcome SteppedBench::open() {
  auto axes = parts_.session.axes(bench_);
  if (!axes) return axes.outcome();
  axes_ = std::move(*axes);
  if (client::Outcome joined = join(); !joined) return joined;
  auto follower = parts_.session.follow(ids_, client::Pace::drive);
  if (!follower) return follower.outcome();
  follower_.emplace(std::move(*follower));
  auto now = parts_.session.observe(ids_);
  if (!now) return now.outcome();
  if (auto held = control_.keep(now->axes)) now = std::move(*held);
  // A loss that an earlier bridge has left in the drives would hide the next one.
  for (client::Axis& axis : axes_) {
    if (client::Outcome told = canopen::tell_connection(axis, false); !told) return told;
  }
  reached_ = now->tick;
  aim_ = reached_;
  nodes_.start(now->axes, time_of(*now));
  return {};
}

client::Outcome SteppedBench::join() {
  clock_.reset();
  auto clock = client::StepClock::join(parts_.session, std::array{bench_});
  if (!clock) return clock.outcome();
  clock_.emplace(std::move(*clock));
  return {};
}

void SteppedBench::close(const std::string& reason) {
  nodes_.stop();
  follower_.reset();
  clock_.reset();
  parts_.reports.report(bridge::Severity::warning, label_,
                        reason + ": its nodes have left the bus");
}

void SteppedBench::note_failure(const client::Outcome& outcome, const char* what) {
  if (parts_.session.is_interrupted()) return;  // the program is ending
  const bool is_lost = outcome.kind() == client::OutcomeKind::lost ||
                       outcome.kind() == client::OutcomeKind::not_found;
  if (is_lost && nodes_.is_running()) {
    close("is lost, " + outcome.message());
  } else if (!is_lost) {
    parts_.reports.report(bridge::Severity::error, label_,
                          std::string(what) + ": " + outcome.message());
  }
}

// ---- time ------------------------------------------------------------------------------------

DriveTime SteppedBench::time_of(const client::Observation& observation) const {
  return tick_period_ * static_cast<std::int64_t>(observation.tick);
}

void SteppedBench::pass_sync() {
  hand_over();
  if (!nodes_.is_running()) return;
  // If the previous SYNC has not been completed, this one continues it.
  if (aim_ == reached_) aim_ = reached_ + ticks_;
  client::Outcome stepped = step();
  // A stepper that kept others waiting too long is removed from the clock: join again.
  if (stepped.kind() == client::OutcomeKind::refused && join()) stepped = step();
  if (!stepped) return note_failure(stepped, "SYNC");
  if (auto held = control_.keep(sample_.axes)) sample_ = std::move(*held);
  nodes_.update(sample_.axes, time_of(sample_));
}

client::Outcome SteppedBench::step() {
  if (aim_ - reached_ > 1) {
    const auto passed = clock_->step(aim_ - reached_ - 1, kStepPatience);
    if (!passed) return passed.outcome();
    reached_ = passed->front();
  }
  // The follower steps the last tick, because it returns the axes.
  client::Outcome shown = follower_->next(kStepPatience, sample_);
  if (shown) reached_ = sample_.tick;
  return shown;
}

// ---- requests of the nodes -------------------------------------------------------------------

void SteppedBench::hand_over() {
  if (!nodes_.has_set_points()) return;
  const client::Outcome sent = parts_.session.send_set_points(bench_, nodes_.take_set_points());
  if (!sent) note_failure(sent, "set-points");
}

void SteppedBench::access(std::size_t place, const DriveAccess& access) {
  // A value that arrived earlier by PDO must act first.
  if (access.value) hand_over();
  nodes_.complete(place, access.ticket, carry_out(axes_.at(place), access));
}

void SteppedBench::tell_connection(std::size_t place, bool is_lost) {
  const client::Outcome told = canopen::tell_connection(axes_.at(place), is_lost);
  if (!told) note_failure(told, "connection loss");
}

void SteppedBench::cycle_power(std::size_t place) {
  const client::Outcome cycled = canopen::cycle_power(axes_.at(place));
  if (!cycled) note_failure(cycled, "power cycle");
}

/// Time stands still, so the values belong to the tick that the nodes have been shown.
void SteppedBench::read(std::size_t place, std::uint32_t ticket,
                        const std::vector<ObjectAddress>& objects) {
  nodes_.take_values(place, ticket, read_values(axes_.at(place), objects));
}

}  // namespace vdrive::canopen
