// SPDX-License-Identifier: Apache-2.0
#include "status_feed.hpp"

#include "vdrive/wire/conversion.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::client {
namespace {

// Four seconds at the usual period; a reader that takes none for longer misses the oldest.
constexpr std::size_t kCapacity = 4096;

}  // namespace

AxisSnapshot sample_of(const msg::AxisStatus& message) {
  return {.id = {message.bench(), message.axis()},
          .tick = message.tick(),
          .status = wire::from_message(message),
          .owner_session = message.owner_session(),
          .owner_epoch = message.owner_epoch(),
          .last_sequence = message.last_sequence()};
}

AxisSnapshot sample_of(const wire::ReceivedStatus& received) {
  return {.id = {received.address.bench, received.address.axis},
          .tick = received.tick,
          .status = received.status,
          .owner_session = received.owner.session,
          .owner_epoch = received.owner.epoch,
          .last_sequence = received.owner.last_sequence};
}

StatusFeed::StatusFeed(BenchKey key, std::vector<std::uint16_t> axes,
                       std::uint32_t status_every_ticks)
    : key_(key),
      count_(axes.size()),
      places_(axes.empty() ? std::size_t{0} : *std::ranges::max_element(axes) + std::size_t{1},
              axes.size()),
      status_every_ticks_(status_every_ticks),
      seen_(axes.size()) {
  for (std::size_t place = 0; place < axes.size(); ++place) places_[axes[place]] = place;
}

void StatusFeed::on_frame(const wire::StatusFrameView& frame) {
  const wire::StatusFrameHead& head = frame.head();
  if (head.bench != key_.number || head.incarnation != key_.incarnation) return;
  if (head.tick < growing_.tick) return;
  const bool has_begun = growing_.axes.size() == count_;  // not before the first frame: tick 0 too
  if (head.tick > growing_.tick || seen_count_ == count_ || !has_begun) start(head.tick);
  for (std::size_t position = 0; position < frame.size(); ++position) {
    const std::size_t number = frame.number(position);
    const std::size_t place = number < places_.size() ? places_[number] : count_;
    if (place == count_ || seen_[place]) continue;
    growing_.axes[place] = sample_of(frame.axis(position));
    seen_[place] = true;
    ++seen_count_;
  }
  if (seen_count_ != count_) return;
  samples_.push_back(
      {.tick = growing_.tick, .missed = 0, .axes = std::exchange(growing_.axes, {})});
  if (samples_.size() > kCapacity) samples_.pop_front();
}

void StatusFeed::start(std::uint64_t tick) {
  growing_.tick = tick;
  growing_.axes.resize(count_);
  seen_.assign(count_, false);
  seen_count_ = 0;
}

std::optional<Observation> StatusFeed::take() {
  if (samples_.empty()) return std::nullopt;
  Observation sample = std::move(samples_.front());
  samples_.pop_front();
  if (last_tick_ && sample.tick > *last_tick_) {
    sample.missed = (sample.tick - *last_tick_ - 1) / status_every_ticks_;
  }
  last_tick_ = sample.tick;
  return sample;
}

}  // namespace vdrive::client
