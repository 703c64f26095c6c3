// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "configuration/configuration.hpp"
#include "seam/queues.hpp"
#include "seam/wire_link.hpp"
#include "vdrive/token_bucket.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::service {

/// Publishes status images: as frames on the topic `status`, and decimated per axis on the topic
/// `axis`. Used by one thread.
class StatusPublisher {
 public:
  /// A sample of one axis costs a client as much as a frame of 256 axes. 50 Hz is enough for a
  /// dashboard, and a limit for all axes together keeps the network free for the frames.
  static constexpr std::chrono::milliseconds kAxisInterval{20};
  static constexpr TokenBucket::Rate kAxisSamples{.per_second = 4'000.0, .burst = 128.0};

  /// @param link outlives this
  StatusPublisher(WireLink& link, const Configuration& configuration, const BenchIdentity& identity,
                  Counters& counters);

  /// Publishes a tick: frames of 256 axes each, unless the image is a repeat, and axis samples,
  /// first of axes that changed state since their last sample, then of those that are due.
  void publish(const StatusImage& image);

  /// @return whether status currently has a reader.
  [[nodiscard]] bool has_readers() const noexcept;

  /// Counts a tick as published although it was not sent, because there were no readers.
  void leave_out(std::uint64_t tick) noexcept { last_tick_ = tick; }

  /// @return the last published tick, 0 = none.
  [[nodiscard]] std::uint64_t last_tick() const noexcept { return last_tick_; }

 private:
  using Clock = std::chrono::steady_clock;

  void publish_frames(const StatusImage& image);
  void publish_axes(const StatusImage& image);
  void publish_axis(const StatusImage& image, std::size_t axis, Clock::time_point now);
  void commit(wire::TopicId topic, std::size_t size);

  struct Sampled {
    std::uint16_t statusword = 0;
    Clock::time_point time{};
  };

  WireLink& link_;
  BenchIdentity identity_;
  std::chrono::nanoseconds period_;
  Counters& counters_;
  std::uint64_t last_tick_ = 0;
  std::vector<std::uint16_t> numbers_;
  std::vector<Sampled> sampled_;
  std::size_t next_due_ = 0;
  TokenBucket axis_samples_{kAxisSamples};
};

}  // namespace vdrive::service
