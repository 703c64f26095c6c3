// SPDX-License-Identifier: Apache-2.0
#include "streams/status_feed.hpp"

#include "vdrive/wire/conversion.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::client {
namespace {

// Four seconds at the usual period; a reader that is later than that loses the oldest samples.
constexpr std::size_t kCapacity = 4096;

// Enough spare samples: one is being filled, one is in use by its reader, and some arrive while the
// reader is late.
constexpr std::size_t kMostSpares = 8;

}  // namespace

AxisSnapshot sample_of(const msg::AxisStatus& message) {
  return {.id = {message.bench, message.axis},
          .tick = message.tick,
          .status = wire::from_message(message),
          .owner_session = message.owner_session,
          .owner_epoch = message.owner_epoch,
          .last_sequence = message.last_sequence};
}

void fill_sample(const wire::ReceivedStatus& received, AxisSnapshot& sample) {
  sample.id = {received.address.bench, received.address.axis};
  sample.tick = received.tick;
  sample.status = received.status;
  sample.owner_session = received.owner.session;
  sample.owner_epoch = received.owner.epoch;
  sample.last_sequence = received.owner.last_sequence;
  sample.skipped = 0;
}

AxisRange range_of(const wire::StatusFrameView& frame) noexcept {
  AxisRange range{.lowest = frame.number(0), .highest = frame.number(0)};
  for (std::size_t position = 1; position < frame.size(); ++position) {
    const std::uint16_t number = frame.number(position);
    range.lowest = std::min(range.lowest, number);
    range.highest = std::max(range.highest, number);
  }
  return range;
}

StatusFeed::StatusFeed(BenchKey key, std::vector<std::uint16_t> axes,
                       std::uint32_t status_every_ticks, std::uint64_t first_tick)
    : key_(key),
      count_(axes.size()),
      places_(axes.empty() ? std::size_t{0} : *std::ranges::max_element(axes) + std::size_t{1},
              axes.size()),
      status_every_ticks_(status_every_ticks),
      seen_(axes.size()) {
  growing_.tick = first_tick;
  if (!axes.empty()) {
    const auto [lowest, highest] = std::ranges::minmax(axes);
    wanted_ = {.lowest = lowest, .highest = highest};
  }
  for (std::size_t place = 0; place < axes.size(); ++place) places_[axes[place]] = place;
}

bool StatusFeed::on_frame(const wire::StatusFrameView& frame) {
  const wire::StatusFrameHead& head = frame.head();
  if (head.bench != key_.number || head.incarnation != key_.incarnation) return false;
  if (head.tick < growing_.tick) return false;
  // growing_.tick is 0 at first: a comparison of ticks alone would not start a sample for tick 0.
  const bool has_begun = growing_.axes.size() == count_;
  // A complete tick received again comes from a bench whose time stands still, and makes another
  // sample.
  if (head.tick > growing_.tick || seen_count_ == count_ || !has_begun) start(head.tick);
  for (std::size_t position = 0; position < frame.size(); ++position) {
    const std::size_t number = frame.number(position);
    const std::size_t place = number < places_.size() ? places_[number] : count_;
    if (place == count_ || seen_[place]) continue;
    fill_sample(frame.axis(position), growing_.axes[place]);
    seen_[place] = true;
    ++seen_count_;
  }
  if (seen_count_ != count_) return false;
  samples_.push_back({.observation = {.tick = growing_.tick,
                                      .missed = 0,
                                      .skipped = 0,
                                      .axes = std::exchange(growing_.axes, {})},
                      .skipped_ticks = head.skipped_ticks});
  if (samples_.size() > kCapacity) {
    keep(std::move(samples_.front().observation.axes));
    samples_.pop_front();
  }
  return true;
}

void StatusFeed::start(std::uint64_t tick) {
  growing_.tick = tick;
  if (growing_.axes.empty() && !spares_.empty()) {
    growing_.axes = std::move(spares_.back());
    spares_.pop_back();
  }
  growing_.axes.resize(count_);  // all entries of a spare are overwritten later
  seen_.assign(count_, false);
  seen_count_ = 0;
}

bool StatusFeed::take(Observation& sample) {
  if (samples_.empty()) return false;
  std::swap(sample, samples_.front().observation);
  const RunTime time{sample.tick, samples_.front().skipped_ticks};
  keep(std::move(samples_.front().observation.axes));
  samples_.pop_front();
  count_gap(sample, time);
  return true;
}

void StatusFeed::count_gap(Observation& sample, const RunTime& time) {
  if (last_ && time.tick > last_->tick) {
    sample.skipped = ticks_skipped(*last_, time);
    skipped_ += sample.skipped;
    const std::uint64_t run = ticks_run(*last_, time);
    sample.missed = run == 0 ? 0 : (run - 1) / status_every_ticks_;
  }
  last_ = time;
  if (skipped_ == 0) return;  // every sample starts with 0
  for (AxisSnapshot& axis : sample.axes) axis.skipped = skipped_;
}

std::optional<Observation> StatusFeed::take() {
  Observation sample;
  if (!take(sample)) return std::nullopt;
  return sample;
}

void StatusFeed::keep(std::vector<AxisSnapshot> axes) {
  if (axes.size() == count_ && spares_.size() < kMostSpares) spares_.push_back(std::move(axes));
}

}  // namespace vdrive::client
