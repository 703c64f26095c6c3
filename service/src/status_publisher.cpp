// SPDX-License-Identifier: Apache-2.0
#include "status_publisher.hpp"

#include <algorithm>

namespace vdrive::service {
namespace {

constexpr std::uint16_t kStateBits = 0x006F;
constexpr double kLargestBurst = 128.0;

}  // namespace

StatusPublisher::StatusPublisher(wire::Participant& participant, const Configuration& configuration,
                                 const BenchIdentity& identity, Counters& counters)
    : frames_(participant),
      axes_(participant),
      identity_(identity),
      period_(configuration.period),
      counters_(counters),
      sampled_(configuration.axes.size()) {
  for (const auto& axis : configuration.axes) {
    numbers_.push_back(axis.number);
  }
  frame_.bench(identity.bench);
  frame_.incarnation(identity.incarnation);
}

void StatusPublisher::publish(const StatusImage& image) {
  if (!image.repeated && frames_.matched() > 0) {
    publish_frames(image);
  }
  publish_axes(image);
  last_tick_ = image.tick;
}

void StatusPublisher::publish_frames(const StatusImage& image) {
  constexpr std::size_t kPartSize = msg::MAX_AXES_PER_FRAME;
  const std::size_t parts = (numbers_.size() + kPartSize - 1) / kPartSize;
  frame_.tick(image.tick);
  frame_.time_ns(static_cast<std::int64_t>(image.tick) * period_.count());
  frame_.parts(static_cast<std::uint16_t>(parts));
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * kPartSize;
    const std::size_t count = std::min(kPartSize, numbers_.size() - first);
    frame_.part(static_cast<std::uint16_t>(part));
    frame_.axes().resize(count);
    for (std::size_t position = 0; position < count; ++position) {
      const std::size_t axis = first + position;
      wire::to_message(image.status[axis], {identity_.bench, numbers_[axis]}, image.tick,
                       image.owners[axis], frame_.axes()[position]);
    }
    if (frames_.write(frame_)) {
      counters_.status_frames_sent.add();
    } else {
      counters_.queue_overflows.add();
    }
  }
}

void StatusPublisher::publish_axes(const StatusImage& image) {
  if (axes_.matched() == 0) {
    return;
  }
  const auto now = Clock::now();
  refill(now);
  for (std::size_t axis = 0; axis < sampled_.size() && budget_ >= 1.0; ++axis) {
    const auto changed = image.status[axis].ds402_statusword ^ sampled_[axis].statusword;
    if ((changed & kStateBits) != 0) {
      publish_axis(image, axis, now);
    }
  }
  for (std::size_t count = 0; count < sampled_.size() && budget_ >= 1.0; ++count) {
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
  wire::to_message(image.status[axis], {identity_.bench, numbers_[axis]}, image.tick,
                   image.owners[axis], sample_);
  sampled_[axis] = {.statusword = image.status[axis].ds402_statusword, .time = now};
  budget_ -= 1.0;
  (axes_.write(sample_) ? counters_.axis_samples_sent : counters_.queue_overflows).add();
}

void StatusPublisher::refill(Clock::time_point now) {
  const double seconds = std::chrono::duration<double>(now - refilled_).count();
  budget_ = std::min(kLargestBurst, budget_ + seconds * kAxisSamplesPerSecond);
  refilled_ = now;
}

}  // namespace vdrive::service
