// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "exchange/bench_links.hpp"
#include "presence/discovery.hpp"
#include "presence/target.hpp"
#include "streams/status_feed.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/sample_reader.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::client {

/// The status that benches publish for their axes: status frames, tick by tick, and axis samples,
/// at intervals. Thread-safe.
class StatusStream {
 public:
  StatusStream(wire::Participant& participant, Discovery& discovery, BenchLinks& links,
               Wakeup& wakeup);

  /// Receives status frames from now on; before that, the session puts no load on the network.
  void subscribe();

  /// Starts collecting the status stream for `axes`, until the last pointer to the feed is gone.
  /// @param first_tick frames of earlier ticks are ignored
  std::shared_ptr<StatusFeed> open_feed(const Target& target, std::vector<std::uint16_t> axes,
                                        std::uint64_t first_tick = 0);

  /// @return whether next() would return a sample immediately.
  [[nodiscard]] bool has_next(const StatusFeed& feed) const;

  /// Waits for the next sample of a feed; the feed reuses the old memory of `sample`.
  Outcome next(const Target& target, StatusFeed& feed, const Patience& patience,
               Observation& sample);

  /// Waits for the next sample of a feed.
  Result<Observation> next(const Target& target, StatusFeed& feed, const Patience& patience);

  /// Does not wait.
  /// @return the newest sample of a feed, with the samples lost and the ticks skipped since the
  ///         last sample taken; nothing if none has arrived since.
  std::optional<Observation> take_newest(StatusFeed& feed);

  /// Waits for an axis sample of each of these axes; a bench also sends them while its time stands
  /// still.
  Result<Observation> next_samples(const Target& target, std::span<const std::uint16_t> axes);

 private:
  void take(std::span<const std::byte> sample);
  void deliver(const wire::Source& source);

  wire::Participant& participant_;
  Discovery& discovery_;
  BenchLinks& links_;
  Wakeup& wakeup_;
  mutable std::mutex mutex_;  ///< guards the feeds and their contents
  std::vector<std::weak_ptr<StatusFeed>> feeds_;
  std::once_flag subscribed_;
  std::optional<wire::StatusFrameHead> taken_;  ///< of the frame that deliver() handles next
  bool is_news_ = false;  ///< that frame ends a tick or completes a sample of a feed
  std::unique_ptr<wire::SampleReader> reader_;
};

}  // namespace vdrive::client
