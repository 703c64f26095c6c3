// SPDX-License-Identifier: Apache-2.0
#include "status_feed.hpp"

#include "vdrive/wire/conversion.hpp"

#include <algorithm>

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

StatusFeed::StatusFeed(BenchKey key, std::vector<std::uint16_t> axes,
                       std::uint32_t status_every_ticks)
    : key_(key), status_every_ticks_(status_every_ticks), seen_(axes.size()) {
  for (std::size_t position = 0; position < axes.size(); ++position) {
    places_.push_back({axes[position], position});
  }
  std::ranges::sort(places_, {}, &Place::axis);
  growing_.axes.resize(axes.size());
}

void StatusFeed::on_frame(const msg::StatusFrame& frame) {
  if (frame.bench() != key_.number || frame.incarnation() != key_.incarnation) return;
  if (frame.tick() < growing_.tick) return;
  if (frame.tick() > growing_.tick || seen_count_ == places_.size()) start(frame.tick());
  for (const msg::AxisStatus& status : frame.axes()) put(status);
  if (seen_count_ != places_.size()) return;
  samples_.push_back(growing_);
  if (samples_.size() > kCapacity) samples_.pop_front();
}

void StatusFeed::start(std::uint64_t tick) {
  growing_.tick = tick;
  seen_.assign(places_.size(), false);
  seen_count_ = 0;
}

void StatusFeed::put(const msg::AxisStatus& status) {
  const auto place = std::ranges::lower_bound(places_, status.axis(), {}, &Place::axis);
  if (place == places_.end() || place->axis != status.axis() || seen_[place->position]) return;
  growing_.axes[place->position] = sample_of(status);
  seen_[place->position] = true;
  ++seen_count_;
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
