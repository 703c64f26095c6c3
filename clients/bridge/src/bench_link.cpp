// SPDX-License-Identifier: Apache-2.0
#include "bench_link.hpp"

#include <iterator>
#include <utility>

namespace vdrive::bridge {
namespace {

using std::chrono::milliseconds;

// Longest delay for requests of the bridge, and for the end of the link, while the bench sends
// nothing.
constexpr milliseconds kLongestFollow{10};

// A new stream delivers nothing at first. In lock-step the state is therefore also requested for
// this long: a step may end before the stream delivers, and perhaps no tick follows.
constexpr std::chrono::seconds kOpeningOfStream{2};
constexpr milliseconds kAskAgainAfter{100};

constexpr std::size_t kWorkers = 8;

}  // namespace

BenchLink::BenchLink(BenchAdapter& adapter, client::Session& session, Reports& reports,
                     const client::BenchInfo& info, BenchControl::Options control)
    : adapter_(adapter),
      session_(session),
      reports_(reports),
      bench_(info.number),
      ids_(ids_of(info)),
      label_(control.label),
      jobs_(ids_.size()),
      follower_([this] {
        return begin();
      }),
      control_(session, reports, ids_, std::move(control)) {
  // A worker has at most one job per axis: none is refused.
  for (std::size_t i = 0; i < kWorkers; ++i) workers_.emplace_back(ids_.size());
  thread_ = std::jthread([this](const std::stop_token& stop) {
    run(stop);
  });
}

// ---- following -------------------------------------------------------------------------------

void BenchLink::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!follower_.is_open() && !follower_.open(Clock::now())) {
      rest(BenchFollower::kRetry, stop);
      continue;
    }
    adapter_.before_turn(*this);
    // Control that a client asks for is acquired even while time stands still. Automatic control is
    // acquired only with a new state, in show(), because each refusal is an event for all clients
    // of the bench.
    if (newest_ && !control_.is_automatic()) {
      if (auto held = control_.keep(newest_->axes)) show(std::move(*held));
    }
    follow();
  }
}

client::Result<BenchFollower::Next> BenchLink::begin() {
  const auto info = session_.find_bench(bench_);
  if (!info) return info.outcome();
  if (ids_of(*info) != ids_) return client::Outcome::failed("the axes of the bench have changed");
  auto found = session_.axes(bench_);
  if (!found) return found.outcome();
  const auto axes = std::make_shared<const std::vector<client::Axis>>(std::move(*found));
  {
    const std::scoped_lock lock(mutex_);
    axes_ = axes;
  }
  // Open the stream before reading the state, so that no tick is missed in between.
  auto next = follow_axes(session_, ids_)();
  if (!next) return next;
  auto now = session_.observe(ids_);
  if (!now) return now.outcome();
  // Start listening for names, so that the name of a session that gets in the way later is known
  // immediately.
  (void)session_.known_name(bench_, 0);
  is_stepped_ = info->clock_mode == client::ClockMode::lockstep;
  opened_ = Clock::now();
  ask_due_ = opened_ + kAskAgainAfter;
  adapter_.on_open(*info, *axes);
  show(std::move(*now));
  return next;
}

void BenchLink::follow() {
  auto newest = follower_.newest(kLongestFollow);
  if (!newest) newest = ask_again();
  if (newest) show(std::move(*newest));
  if (follower_.is_open()) return;
  newest_.reset();
  adapter_.on_lost();
}

/// @return a state that the stream missed while it was being opened; nothing if there is no newer
///         one.
std::optional<client::Observation> BenchLink::ask_again() {
  const auto now = Clock::now();
  const bool is_due = now >= ask_due_ && now < opened_ + kOpeningOfStream;
  if (!is_stepped_ || !follower_.is_open() || !is_due) return std::nullopt;
  ask_due_ = now + kAskAgainAfter;
  auto seen = session_.observe(ids_);
  if (!seen || seen->tick <= newest_->tick) return std::nullopt;
  return std::move(*seen);
}

void BenchLink::show(client::Observation&& observation) {
  auto held = control_.keep(observation.axes);
  newest_ =
      std::make_shared<const client::Observation>(held ? std::move(*held) : std::move(observation));
  adapter_.on_state(newest_);
}

// ---- jobs ------------------------------------------------------------------------------------

bool BenchLink::post(std::size_t place, AxisJobs::Kind kind, Job job) {
  {
    const std::scoped_lock lock(mutex_);
    if (!axes_) return false;
    WaitingJobs& waiting = jobs_.at(place);
    const bool is_taken = waiting.jobs.add(kind, [known = axes_, place, job = std::move(job)] {
      client::Axis axis = known->at(place);  // a handle
      job(axis);
    });
    if (!is_taken) return false;
    if (std::exchange(waiting.is_posted, true)) return true;
  }
  post_next(workers_.at(place % workers_.size()), place);
  return true;
}

void BenchLink::post_next(Worker& worker, std::size_t place) {
  (void)worker.post([this, &worker, place] {
    work(worker, place);
  });
}

/// Runs the oldest job of an axis and queues the next one after the jobs of other axes.
void BenchLink::work(Worker& worker, std::size_t place) {
  AxisJobs::Job job;
  {
    const std::scoped_lock lock(mutex_);
    job = jobs_.at(place).jobs.take();
  }
  job();
  {
    const std::scoped_lock lock(mutex_);
    WaitingJobs& waiting = jobs_.at(place);
    waiting.is_posted = !waiting.jobs.is_empty();
    if (!waiting.is_posted) return;
  }
  post_next(worker, place);
}

// ---- set-points ------------------------------------------------------------------------------

void BenchLink::send(std::vector<client::SetPointFrame> frames) {
  {
    const std::scoped_lock lock(mutex_);
    for (client::SetPointFrame& frame : frames) frames_.put(std::move(frame));
    if (std::exchange(is_sending_, true)) return;
  }
  (void)sender_.post([this] {
    send_waiting();
  });
}

void BenchLink::send_waiting() {
  while (true) {
    std::deque<client::SetPointFrame> waiting;
    {
      const std::scoped_lock lock(mutex_);
      is_sending_ = !frames_.empty();
      if (!is_sending_) return;
      waiting = frames_.take_all();
    }
    const std::vector<client::SetPointFrame> frames(std::make_move_iterator(waiting.begin()),
                                                    std::make_move_iterator(waiting.end()));
    report(session_.send_set_points(bench_, frames), label_, "set-points: ");
  }
}

std::uint64_t BenchLink::dropped_frames() const {
  const std::scoped_lock lock(mutex_);
  return frames_.dropped();
}

void BenchLink::report(const client::Outcome& outcome, const std::string& subject,
                       const std::string& what) {
  if (outcome || outcome.kind() == client::OutcomeKind::lost || session_.is_interrupted()) return;
  reports_.report(Severity::warning, subject, what + outcome.message());
}

}  // namespace vdrive::bridge
