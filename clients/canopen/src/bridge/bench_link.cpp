// SPDX-License-Identifier: Apache-2.0
#include "bridge/bench_link.hpp"

#include "bridge/drive_access.hpp"

#include <iterator>
#include <optional>
#include <utility>

namespace vdrive::canopen {
namespace {

using std::chrono::milliseconds;

// How long the end of the link waits while the bench sends nothing.
constexpr milliseconds kLongestFollow{10};

// The stream reaches a reader from some milliseconds after it was opened on. A step that ends
// within this time is asked for: in lock-step no other tick would follow it.
constexpr std::chrono::seconds kOpeningOfStream{2};
constexpr milliseconds kAskAgainAfter{100};

}  // namespace

BenchLink::BenchLink(client::Session& session, const client::BenchInfo& info, std::string label,
                     bridge::Reports& reports, std::function<void()> notify)
    : session_(session),
      bench_(info.number),
      ids_(ids_of(info)),
      label_(std::move(label)),
      reports_(reports),
      notify_(std::move(notify)),
      jobs_(ids_.size()),
      period_(info.period),
      follower_([this] {
        return begin();
      }),
      control_(session, ids_, label_, reports) {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    run(stop);
  });
}

// ---- following -------------------------------------------------------------------------------

void BenchLink::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (follower_.is_open() || follower_.open(bridge::BenchFollower::Clock::now())) {
      follow();
    } else {
      bridge::rest(bridge::BenchFollower::kRetry, stop);
    }
  }
}

client::Result<bridge::BenchFollower::Next> BenchLink::begin() {
  const auto info = session_.find_bench(bench_);
  if (!info) return info.outcome();
  if (ids_of(*info) != ids_) return client::Outcome::failed("the bench has other axes");
  auto axes = session_.axes(bench_);
  if (!axes) return axes.outcome();
  period_ = info->period;
  {
    const std::scoped_lock lock(mutex_);
    axes_ = std::make_shared<const std::vector<client::Axis>>(std::move(*axes));
  }
  // The stream before the state: no tick is missing between them.
  auto next = bridge::follow_axes(session_, ids_)();
  if (!next) return next;
  auto now = session_.observe(ids_);
  if (!now) return now.outcome();
  // Begins to listen: a session that stands in the way later has a name at once.
  (void)session_.known_name(bench_, 0);
  is_stepped_ = info->clock_mode == client::ClockMode::lockstep;
  opened_ = bridge::BenchFollower::Clock::now();
  ask_due_ = opened_ + kAskAgainAfter;
  show(std::move(*now));
  return next;
}

void BenchLink::follow() {
  auto newest = follower_.newest(kLongestFollow);
  if (!newest) newest = ask_again();
  if (newest) show(std::move(*newest));
  if (!follower_.is_open()) tell({.was_lost = true});
}

/// @return a state that the stream did not show while it was opened; none when it is not newer.
std::optional<client::Observation> BenchLink::ask_again() {
  const auto now = bridge::BenchFollower::Clock::now();
  const bool is_due = now >= ask_due_ && now < opened_ + kOpeningOfStream;
  if (!is_stepped_ || !follower_.is_open() || !is_due) return std::nullopt;
  ask_due_ = now + kAskAgainAfter;
  auto seen = session_.observe(ids_);
  if (!seen || seen->tick <= shown_tick_) return std::nullopt;
  return std::move(*seen);
}

void BenchLink::show(client::Observation&& observation) {
  auto held = control_.keep(observation.axes);
  auto state = std::make_shared<State>();
  state->observation = held ? std::move(*held) : std::move(observation);
  shown_tick_ = state->observation.tick;
  const client::AxisSnapshot& first = state->observation.axes.front();
  state->time = period_ * static_cast<std::int64_t>(first.driven_tick());
  tell({.newest = std::move(state)});
}

void BenchLink::tell(News news) {
  {
    const std::scoped_lock lock(mutex_);
    if (news.was_lost) {
      news_ = std::move(news);
    } else {
      news_.newest = std::move(news.newest);
    }
    if (std::exchange(are_news_, true)) return;
  }
  notify_();
}

BenchLink::News BenchLink::take_news() {
  const std::scoped_lock lock(mutex_);
  are_news_ = false;
  return std::exchange(news_, {});
}

// ---- calls -----------------------------------------------------------------------------------

/// @return false when the job was not taken.
bool BenchLink::post(std::size_t place, DriveJobs::Kind kind,
                     std::function<void(client::Axis& axis)> job) {
  {
    const std::scoped_lock lock(mutex_);
    WaitingJobs& waiting = jobs_.at(place);
    const bool is_taken = waiting.jobs.add(kind, [known = axes_, place, job = std::move(job)] {
      client::Axis axis = known->at(place);  // a handle
      job(axis);
    });
    if (!is_taken) return false;
    if (std::exchange(waiting.is_posted, true)) return true;
  }
  post_next(place);
  return true;
}

/// A worker has one job for each of its axes at most, which are fewer than it takes: only its end
/// refuses one.
void BenchLink::post_next(std::size_t place) {
  (void)workers_.at(place % workers_.size()).post([this, place] {
    work(place);
  });
}

/// Carries out the oldest job of an axis; the next one waits behind those of other axes.
void BenchLink::work(std::size_t place) {
  DriveJobs::Job job;
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
  post_next(place);
}

void BenchLink::access(std::size_t place, const DriveAccess& access,
                       const std::function<void(const DriveAnswer&)>& done) {
  const bool is_taken = post(place, DriveJobs::Kind::access, [access, done](client::Axis& axis) {
    done(carry_out(axis, access));
  });
  if (!is_taken) done({.abort = AbortCode::cannot_store_or_transfer});
}

void BenchLink::read(std::size_t place, std::vector<ObjectAddress> objects,
                     const std::function<void(const std::vector<DriveValue>&)>& done) {
  const bool is_taken =
      post(place, DriveJobs::Kind::access, [asked = std::move(objects), done](client::Axis& axis) {
        done(read_values(axis, asked));
      });
  if (!is_taken) done({});
}

void BenchLink::tell_connection(std::size_t place, bool is_lost) {
  (void)post(place, DriveJobs::Kind::connection, [this, place, is_lost](client::Axis& axis) {
    report_failure(canopen::tell_connection(axis, is_lost), place);
  });
}

void BenchLink::cycle_power(std::size_t place) {
  (void)post(place, DriveJobs::Kind::power_cycle, [this, place](client::Axis& axis) {
    report_failure(canopen::cycle_power(axis), place);
  });
}

void BenchLink::report_failure(const client::Outcome& outcome, std::size_t place) {
  // A bench that is lost is reported as such, and a program that ends reports nothing.
  if (outcome || outcome.kind() == client::OutcomeKind::lost || session_.is_interrupted()) return;
  reports_.report(bridge::Severity::warning, "axis " + to_string(ids_.at(place)),
                  outcome.message());
}

void BenchLink::send(std::vector<client::SetPointFrame> frames) {
  {
    const std::scoped_lock lock(mutex_);
    waiting_.insert(waiting_.end(), std::make_move_iterator(frames.begin()),
                    std::make_move_iterator(frames.end()));
    if (waiting_.size() > kMostWaitingFrames) {
      // The newest values count.
      const auto beyond = static_cast<std::ptrdiff_t>(waiting_.size() - kMostWaitingFrames);
      waiting_.erase(waiting_.begin(), waiting_.begin() + beyond);
      dropped_frames_ += static_cast<std::uint64_t>(beyond);
    }
    if (std::exchange(is_sending_, true)) return;
  }
  (void)sender_.post([this] {
    send_waiting();
  });
}

void BenchLink::send_waiting() {
  while (true) {
    std::vector<client::SetPointFrame> frames;
    {
      const std::scoped_lock lock(mutex_);
      is_sending_ = !waiting_.empty();
      if (!is_sending_) return;
      frames.swap(waiting_);
    }
    const client::Outcome sent = session_.send_set_points(bench_, frames);
    if (sent || sent.kind() == client::OutcomeKind::lost || session_.is_interrupted()) continue;
    reports_.report(bridge::Severity::warning, label_, "set-points: " + sent.message());
  }
}

std::uint64_t BenchLink::dropped_frames() const {
  const std::scoped_lock lock(mutex_);
  return dropped_frames_;
}

}  // namespace vdrive::canopen
