// SPDX-License-Identifier: Apache-2.0
#include "streams/status_stream.hpp"

#include "vdrive/wire/subscription.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <utility>

namespace vdrive::client {
namespace {

// Long enough for a large bench, which sends the samples of its axes in turn.
constexpr Patience kFirstSampleOfAll{std::chrono::milliseconds(5000), true};

}  // namespace

StatusStream::StatusStream(wire::Participant& participant, Discovery& discovery, BenchLinks& links,
                           Wakeup& wakeup)
    : participant_(participant), discovery_(discovery), links_(links), wakeup_(wakeup) {}

void StatusStream::subscribe() {
  std::call_once(subscribed_, [this] {
    reader_ = participant_.make_reader(wire::Topic<msg::StatusFrame>::kId,
                                       {.take =
                                            [this](std::span<const std::byte> sample) {
                                              take(sample);
                                            },
                                        .deliver =
                                            [this](const wire::Source& source) {
                                              deliver(source);
                                            }});
  });
}

/// Reads the frame in the library's buffer, because at a thousand axes per millisecond another copy
/// would cost too much.
void StatusStream::take(std::span<const std::byte> sample) {
  taken_.reset();
  const auto frame = wire::StatusFrameView::of(sample);
  if (!frame || !discovery_.sees(frame->head().bench)) return;
  taken_ = frame->head();
  is_news_ = taken_->part + 1 >= taken_->parts;
  if (frame->size() == 0) return;
  std::optional<AxisRange> range;  // none without a feed, as when only watching services
  const std::scoped_lock lock(mutex_);
  for (const auto& weak : feeds_) {
    const auto feed = weak.lock();
    if (!feed) continue;
    if (!range) range = range_of(*frame);
    if (feed->wants(*range)) is_news_ = feed->on_frame(*frame) || is_news_;
  }
}

void StatusStream::deliver(const wire::Source& source) {
  if (!taken_) return;
  discovery_.note_frame({taken_->bench, taken_->incarnation}, {taken_->tick, taken_->skipped_ticks},
                        source);
  // Not for each part of a tick: waiting threads would wake for nothing and compete with the
  // receiving thread.
  if (is_news_) wakeup_.notify();
}

std::shared_ptr<StatusFeed> StatusStream::open_feed(const Target& target,
                                                    std::vector<std::uint16_t> axes,
                                                    std::uint64_t first_tick) {
  auto feed = std::make_shared<StatusFeed>(target.key, std::move(axes), target.status_every_ticks,
                                           first_tick);
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(feeds_, [](const auto& weak) {
      return weak.expired();
    });
    feeds_.push_back(feed);
  }
  subscribe();
  return feed;
}

bool StatusStream::has_next(const StatusFeed& feed) const {
  const std::scoped_lock lock(mutex_);
  return feed.has_sample();
}

Outcome StatusStream::next(const Target& target, StatusFeed& feed, const Patience& patience,
                           Observation& sample) {
  return links_.wait(target, patience, [&] {
    const std::scoped_lock lock(mutex_);
    return feed.take(sample);
  });
}

Result<Observation> StatusStream::next(const Target& target, StatusFeed& feed,
                                       const Patience& patience) {
  Observation sample;
  Outcome outcome = next(target, feed, patience, sample);
  if (!outcome) return outcome;
  return sample;
}

std::optional<Observation> StatusStream::take_newest(StatusFeed& feed) {
  const std::scoped_lock lock(mutex_);
  std::optional<Observation> newest;
  std::uint64_t missed = 0;
  std::uint64_t skipped = 0;
  while (auto sample = feed.take()) {
    missed += sample->missed;
    skipped += sample->skipped;
    newest = std::move(sample);
  }
  if (newest) {
    newest->missed = missed;
    newest->skipped = skipped;
  }
  return newest;
}

Result<Observation> StatusStream::next_samples(const Target& target,
                                               std::span<const std::uint16_t> axes) {
  std::mutex mutex;
  std::map<std::uint16_t, msg::AxisStatus> seen;  // guarded by `mutex`
  // Declared last: its destructor waits for the handler, which uses both.
  const wire::Subscription<msg::AxisStatus> samples(
      participant_, [&](const msg::AxisStatus& message, const wire::Source& source) {
        if (message.bench != target.key.number) return;
        if (source != discovery_.source_of(target.key)) return;
        {
          const std::scoped_lock lock(mutex);
          seen.insert_or_assign(message.axis, message);
        }
        wakeup_.notify();
      });
  const Outcome outcome = links_.wait(target, kFirstSampleOfAll, [&] {
    const std::scoped_lock lock(mutex);
    return std::ranges::all_of(axes, [&](std::uint16_t axis) {
      return seen.contains(axis);
    });
  });
  if (!outcome) return outcome;
  const std::scoped_lock lock(mutex);
  Observation observation;
  for (const std::uint16_t axis : axes) {
    observation.axes.push_back(sample_of(seen.at(axis)));
    observation.tick = std::max(observation.tick, seen.at(axis).tick);
  }
  return observation;
}

}  // namespace vdrive::client
