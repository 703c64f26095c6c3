// SPDX-License-Identifier: Apache-2.0
#include "live/live_judge.hpp"

#include "judge/bench_records.hpp"
#include "vdrive/cia402/controlword.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace vdrive::judge {
namespace {

using client::AxisWrite;
using client::Observation;
using client::Outcome;

/// The most samples of one poll(), so that the verdict can be shown between two polls.
constexpr std::size_t kMostSamples = 2'000;

/// A page with fewer writes was not full: it has room for 64 entries, and a write needs at most
/// three (itself and two marks).
constexpr std::size_t kLeastOfAFullPage = 20;

std::vector<client::AxisId> ids_of(const std::vector<client::Axis>& axes) {
  std::vector<client::AxisId> ids;
  ids.reserve(axes.size());
  for (const client::Axis& axis : axes) ids.push_back(axis.id());
  return ids;
}

/// The most writes kept: while time stands still, the status that they wait for does not arrive.
constexpr std::size_t kMostWrites = 65'536;

bool is_set_point(const AxisWrite& write) {
  return write.kind == AxisWrite::Kind::write && write.object == objects::kControlword &&
         write.reason == 0 && (write.value & Controlword::kNewSetPoint) != 0;
}

}  // namespace

client::Result<LiveJudge> LiveJudge::create(client::Session& session, std::uint32_t bench,
                                            std::vector<client::Axis> axes) {
  const auto found = session.find_bench(bench);
  if (!found) return found.outcome();
  auto follower = session.follow(ids_of(axes), client::Pace::observe);
  if (!follower) return follower.outcome();
  LiveJudge judge(session, *found, std::move(*follower), std::move(axes));
  if (Outcome begun = judge.begin(); !begun) return begun;
  return judge;
}

LiveJudge::LiveJudge(client::Session& session, const client::BenchInfo& bench,
                     client::Follower follower, std::vector<client::Axis> axes)
    : session_(&session),
      bench_(bench.number),
      is_realtime_(bench.clock_mode == ClockMode::realtime),
      period_(bench.period),
      follower_(std::move(follower)),
      axes_(std::move(axes)),
      ignored_(axes_.size()),
      judge_({.has_time = true,
              .shows_reads = false,
              .shows_sessions = true,
              .speed_is_per_second = true}) {}

/// Starts at the present: earlier writes are not judged, because their status was not seen.
Outcome LiveJudge::begin() {
  const auto present = session_->writes(bench_, std::numeric_limits<std::uint64_t>::max());
  if (!present) return present.outcome();
  place_ = present->place;
  const auto state = session_->observe(ids_of(axes_));
  if (!state) return state.outcome();
  known_tick_ = first_tick_ = judged_tick_ = state->tick;
  if (Outcome shown = show_objects(); !shown) return shown;
  for (std::size_t place = 0; place < axes_.size(); ++place) {
    const client::AxisSnapshot& axis = state->axes[place];
    ignored_[place] = axis.status.ignored_set_points;
    take(first_tick_, axis.id.axis, shown_by(axis.status));
  }
  return {};
}

Outcome LiveJudge::show_objects() {
  for (const client::Axis& axis : axes_) {
    const auto read = axis.read(std::span(kKnownFromTheStart));
    if (!read) return read.outcome();
    for (const client::ObjectReading& reading : read->objects) {
      if (reading.code != AbortCode::none) continue;
      take(known_tick_, axis.id().axis,
           Reading{.object = reading.object, .value = reading.value, .is_of_the_master = false});
    }
  }
  return {};
}

Outcome LiveJudge::poll(std::chrono::milliseconds patience) {
  if (Outcome taken = take_samples(patience); !taken) return taken;
  if (Outcome taken = take_writes(); !taken) return taken;
  judge_until_known();
  return {};
}

Outcome LiveJudge::take_samples(std::chrono::milliseconds patience) {
  for (std::size_t count = 0; count < kMostSamples; ++count) {
    if (count > 0 && !follower_.has_next()) break;
    Observation sample;
    if (!spent_.empty()) {
      sample = std::move(spent_.back());
      spent_.pop_back();
    }
    Outcome seen = follower_.next(patience, sample);
    if (seen.kind() == client::OutcomeKind::timed_out) break;
    if (!seen) return seen;
    samples_.push_back(std::move(sample));
  }
  return {};
}

/// Takes writes as far as the samples need them. Masters may write faster than pages arrive.
Outcome LiveJudge::take_writes() {
  while (true) {
    const auto page = session_->writes(bench_, place_);
    if (!page) return page.outcome();
    place_ = page->place;
    for (const AxisWrite& write : page->writes) {
      if (write.tick >= first_tick_) writes_.push_back(write);
    }
    if (writes_.size() > kMostWrites) {
      writes_.clear();
      lose(judged_tick_, "writes are missing");
    }
    const bool is_full = page->writes.size() >= kLeastOfAFullPage;
    known_tick_ = is_full ? page->writes.back().tick : page->tick;
    if (!is_full || samples_.empty() || known_tick_ >= samples_.back().tick) return {};
  }
}

void LiveJudge::judge_until_known() {
  while (!samples_.empty() && samples_.front().tick <= known_tick_) {
    Observation& sample = spent_.emplace_back(std::move(samples_.front()));
    samples_.pop_front();
    // A completed tick may be published again.
    if (sample.tick > judged_tick_) judge_sample(sample);
  }
}

void LiveJudge::judge_sample(const Observation& sample) {
  if (is_realtime_ && sample.missed > 0) lose(judged_tick_, "status is missing");
  judge_writes_before(sample);
  judged_tick_ = sample.tick;
  for (std::size_t place = 0; place < axes_.size(); ++place) {
    const client::AxisSnapshot& axis = sample.axes[place];
    ignored_[place] = axis.status.ignored_set_points;
    take(sample.tick, axis.id.axis, shown_by(axis.status));
  }
}

/// A status shows how many set-points the drive has ignored since the previous status. They are
/// taken to be the last ones written in that time.
void LiveJudge::judge_writes_before(const Observation& sample) {
  const auto end = std::ranges::find_if(writes_, [&](const AxisWrite& write) {
    return write.tick >= sample.tick;
  });
  if (end == writes_.begin()) return;
  std::vector<AxisWrite> due(writes_.begin(), end);
  writes_.erase(writes_.begin(), end);
  std::vector<bool> is_ignored(due.size());
  std::vector<std::uint32_t> left(axes_.size());
  for (std::size_t place = 0; place < axes_.size(); ++place) {
    const std::uint32_t now = sample.axes[place].status.ignored_set_points;
    left[place] =
        now < ignored_[place] ? 0 : now - ignored_[place];  // counted from the last power-up
  }
  for (std::size_t i = due.size(); i-- > 0;) {
    const auto place = place_of(due[i].axis);
    if (!place || left[*place] == 0 || !is_set_point(due[i])) continue;
    is_ignored[i] = true;
    --left[*place];
  }
  for (std::size_t i = 0; i < due.size(); ++i) judge_write(due[i], is_ignored[i]);
}

void LiveJudge::judge_write(const AxisWrite& write, bool is_ignored) {
  switch (write.kind) {
    case AxisWrite::Kind::lost:
      return lose(write.tick, "writes are missing");
    case AxisWrite::Kind::restored:
      return lose(write.tick, "snapshot");
    case AxisWrite::Kind::power_cycle:
      if (place_of(write.axis)) take(write.tick, write.axis, Gap{"power cycle"});
      return;
    case AxisWrite::Kind::connection_loss:  // visible in the status
      return;
    case AxisWrite::Kind::write:
      break;
  }
  const bool is_of_a_master =
      write.means != AxisWrite::Means::bench && !is_test_input(write.object);
  if (!is_of_a_master || !place_of(write.axis)) return;
  Fate fate = is_ignored ? Fate::ignored : Fate::accepted;
  if (write.is_late) {
    fate = Fate::late;
  } else if (write.reason != 0) {
    fate = Fate::refused;
  }
  take(write.tick, write.axis,
       Write{.object = write.object,
             .value = write.value,
             .channel = write.means == AxisWrite::Means::frame ? Channel::frame : Channel::request,
             .fate = fate,
             .code = write.reason,
             .writer = write.session});
}

void LiveJudge::lose(std::uint64_t tick, std::string_view cause) {
  for (const client::Axis& axis : axes_) take(tick, axis.id().axis, Gap{cause});
}

std::optional<std::size_t> LiveJudge::place_of(std::uint16_t axis) const {
  const auto found = std::ranges::find(axes_, axis, [](const client::Axis& each) {
    return each.id().axis;
  });
  if (found == axes_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - axes_.begin());
}

void LiveJudge::take(std::uint64_t tick, std::uint32_t axis, const decltype(Record::what)& what) {
  judge_.take({.time = time_of(tick), .tick = tick, .axis = axis, .what = what});
}

}  // namespace vdrive::judge
