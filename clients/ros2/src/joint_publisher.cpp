// SPDX-License-Identifier: Apache-2.0
#include "joint_publisher.hpp"

#include "diagnostics.hpp"
#include "joint_values.hpp"
#include "ros_time.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace vdrive::ros2 {
namespace {

using std::chrono::milliseconds;

// How often a bench in lock-step is checked for the end of a step, whose state must be published.
constexpr milliseconds kSilentTurn{10};
constexpr milliseconds kEndOfStep{20};  // without a further tick for this time, the step has ended

// A node that joins while no tick passes must see the joints too. It may read best effort, and its
// match does not show which samples reach it.
constexpr std::chrono::seconds kRepeat{1};

// Expected by readers of /diagnostics: after some seconds without a message they show STALE.
constexpr std::chrono::seconds kDiagnostics{1};

/// @return which nodes can find the bridge, for the diagnostics.
std::string network_text(const client::SessionOptions& options) {
  return options.interfaces.empty() ? "loopback only" : joined(options.interfaces);
}

}  // namespace

bool StateTimes::take(const client::BenchInfo& bench, std::uint64_t tick, Clock::time_point now) {
  Published& published = published_[bench.number];
  // The first state of a run is published immediately, whatever its tick.
  if (published.incarnation != bench.incarnation) {
    published = {.incarnation = bench.incarnation, .tick = tick + 1, .due = now};
  }
  if (!is_due(published, bench, tick, now)) return false;
  published.tick = tick;
  published.taken = now;
  return true;
}

bool StateTimes::is_due(Published& published, const client::BenchInfo& bench, std::uint64_t tick,
                        Clock::time_point now) const {
  if (tick == published.tick) return now - published.taken >= kRepeat;
  return bench.clock_mode == client::ClockMode::lockstep
             ? is_due_in_lockstep(published, bench, tick, now)
             : is_due_at_rate(published, now);
}

bool StateTimes::is_due_at_rate(Published& published, Clock::time_point now) const {
  if (now < published.due) return false;
  // A late message does not shift the following ones, unless it is late by more than one period.
  published.due += period_;
  if (published.due < now) published.due = now + period_;
  return true;
}

bool StateTimes::is_due_in_lockstep(Published& published, const client::BenchInfo& bench,
                                    std::uint64_t tick, Clock::time_point now) const {
  if (tick != published.waiting) {
    published.waiting = tick;
    published.waiting_since = now;
  }
  // In doubles, because the bench may have gone back to a lower tick.
  const double passed = (static_cast<double>(tick) - static_cast<double>(published.tick)) *
                        std::chrono::duration<double>(bench.period).count();
  return passed * rate_ >= 1.0 || passed < 0.0 || now - published.waiting_since >= kEndOfStep;
}

StateTimes::Clock::time_point StateTimes::next(Clock::time_point now) const {
  Clock::time_point next = now + std::min<Clock::duration>(period_, kSilentTurn);
  for (const auto& [number, published] : published_) {
    if (published.due > now) next = std::min(next, published.due);
  }
  return next;
}

std::optional<ros::JointState> joint_state_of(const BenchView& view) {
  if (!view.state) return std::nullopt;
  ros::JointState message;
  message.header.stamp = ros_time(stamp_of(view.bench->info(), view.state->tick));
  const std::size_t count = view.bench->joints().size();
  message.name.reserve(count);
  message.position.reserve(count);
  message.velocity.reserve(count);
  message.effort.reserve(view.limits ? count : 0);
  for (std::size_t i = 0; i < count; ++i) {
    const ServedJoint& joint = view.bench->joints()[i];
    bridge::JointScale scale{.si_per_user_unit = joint.si_per_user_unit};
    if (view.limits) scale.effort_per_mille = (*view.limits)[i].effort_per_mille;
    const bridge::JointValues values = bridge::joint_values(view.state->axes[i].status, scale);
    message.name.push_back(joint.name);
    message.position.push_back(values.position);
    message.velocity.push_back(values.velocity);
    if (view.limits) message.effort.push_back(values.effort);
  }
  return message;
}

JointPublisher::JointPublisher(wire::Participant& participant, const Settings& settings,
                               Board& board)
    : network_(network_text(settings.session)),
      board_(board),
      times_(settings.rate),
      states_(participant, settings.topics.joint_states),
      clock_(participant, settings.topics.clock),
      diagnostics_(participant, settings.topics.diagnostics),
      thread_([this](const std::stop_token& stop) {
        run(stop);
      }) {}

void JointPublisher::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const Clock::time_point now = Clock::now();
    const Board::Views views = board_.views();
    publish(views, now);
    publish_diagnostics(views, now);
    board_.wait_until(times_.next(now), stop);
  }
}

void JointPublisher::publish(const Board::Views& views, Clock::time_point now) {
  bool has_clock = false;
  for (const auto& [number, view] : views) {
    if (!view.state) continue;
    const client::BenchInfo& bench = view.bench->info();
    // ROS has one clock: that of the first bench whose time is not the time of day.
    const bool is_clock = !has_clock && bench.clock_mode != client::ClockMode::realtime;
    has_clock = has_clock || is_clock;
    if (!times_.take(bench, view.state->tick, now)) continue;
    if (is_clock) {
      ros::Clock time;
      time.clock = ros_time(stamp_of(bench, view.state->tick));
      (void)clock_.write(time);
    }
    if (const auto message = joint_state_of(view)) (void)states_.write(*message);
  }
}

void JointPublisher::publish_diagnostics(const Board::Views& views, Clock::time_point now) {
  std::string levels = levels_of(views);
  if (now < diagnostics_due_ && levels == last_levels_) return;
  diagnostics_due_ = now + kDiagnostics;
  last_levels_ = std::move(levels);
  (void)diagnostics_.write(diagnostics_of(views, network_));
}

}  // namespace vdrive::ros2
