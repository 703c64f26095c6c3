// SPDX-License-Identifier: Apache-2.0
#include "publish/status_publisher.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/wire/status_frame.hpp"

#include <algorithm>
#include <span>

namespace vdrive::service {

StatusPublisher::StatusPublisher(WireLink& link, const Configuration& configuration,
                                 const BenchIdentity& identity, Counters& counters)
    : link_(link),
      identity_(identity),
      period_(configuration.period),
      counters_(counters),
      sampled_(configuration.axes.size()) {
  for (const auto& axis : configuration.axes) numbers_.push_back(axis.number);
}

void StatusPublisher::publish(const StatusImage& image) {
  if (!image.repeated && link_.matched(wire::Topic<msg::StatusFrame>::kId) > 0) {
    publish_frames(image);
  }
  publish_axes(image);
  last_tick_ = image.tick;
  link_.flush(Lane::status);
}

bool StatusPublisher::has_readers() const noexcept {
  return link_.matched(wire::Topic<msg::StatusFrame>::kId) > 0 ||
         link_.matched(wire::Topic<msg::AxisStatus>::kId) > 0;
}

void StatusPublisher::publish_frames(const StatusImage& image) {
  constexpr std::size_t kPartSize = msg::MAX_AXES_PER_FRAME;
  const std::size_t parts = (numbers_.size() + kPartSize - 1) / kPartSize;
  ByteRing& ring = link_.ring(Lane::status);
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * kPartSize;
    const std::size_t count = std::min(kPartSize, numbers_.size() - first);
    const auto place = ring.reserve(wire::encoded_status_frame_size(count));
    if (!place) {
      counters_.queue_overflows.add();
      counters_.status_samples_lost.add();
      return;
    }
    const std::size_t size = wire::encode_status_frame(
        {.bench = identity_.bench,
         .skipped_ticks = static_cast<std::uint32_t>(image.skipped),
         .incarnation = identity_.incarnation,
         .tick = image.tick,
         .time_ns = static_cast<std::int64_t>(image.tick) * period_.count(),
         .part = static_cast<std::uint16_t>(part),
         .parts = static_cast<std::uint16_t>(parts)},
        {.status = std::span(image.status).subspan(first, count),
         .owners = std::span(image.owners).subspan(first, count),
         .numbers = std::span(numbers_).subspan(first, count)},
        *place);
    commit(wire::Topic<msg::StatusFrame>::kId, size);
    counters_.status_frames_sent.add();
  }
}

void StatusPublisher::commit(wire::TopicId topic, std::size_t size) {
  ensure(size > 0, "a sample fits into the room that was reserved for it");
  link_.ring(Lane::status)
      .commit({.size = static_cast<std::uint32_t>(size),
               .full_size = static_cast<std::uint32_t>(size),
               .topic = static_cast<std::uint16_t>(topic),
               .flags = 0,
               .party = {}});
}

void StatusPublisher::publish_axes(const StatusImage& image) {
  if (link_.matched(wire::Topic<msg::AxisStatus>::kId) == 0) return;
  const auto now = Clock::now();
  axis_samples_.refill(now.time_since_epoch());
  for (std::size_t axis = 0; axis < sampled_.size() && !axis_samples_.is_empty(); ++axis) {
    const auto changed = image.status[axis].ds402_statusword ^ sampled_[axis].statusword;
    if ((changed & Statusword::kState) != 0) publish_axis(image, axis, now);
  }
  for (std::size_t count = 0; count < sampled_.size() && !axis_samples_.is_empty(); ++count) {
    const std::size_t axis = next_due_;
    if (now - sampled_[axis].time < kAxisInterval) {
      return;  // the others were sampled later than this one
    }
    next_due_ = (next_due_ + 1) % sampled_.size();
    publish_axis(image, axis, now);
  }
}

void StatusPublisher::publish_axis(const StatusImage& image, std::size_t axis,
                                   Clock::time_point now) {
  sampled_[axis] = {.statusword = image.status[axis].ds402_statusword, .time = now};
  static_cast<void>(axis_samples_.take());
  const auto place = link_.ring(Lane::status).reserve(wire::kAxisStatusSize);
  if (!place) {
    counters_.queue_overflows.add();
    counters_.status_samples_lost.add();
    return;
  }
  commit(wire::Topic<msg::AxisStatus>::kId,
         wire::encode_axis_status(image.status[axis], {identity_.bench, numbers_[axis]}, image.tick,
                                  image.owners[axis], *place));
  counters_.axis_samples_sent.add();
}

}  // namespace vdrive::service
