// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services.hpp"
#include "vdrive/client/event.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <vector>

namespace vdrive::gateway {

/// The last events of each bench, for a client that comes later or was not connected. Any thread.
class EventLog {
 public:
  static constexpr std::size_t kMostOfABench = 1'024;

  /// Benches with events. Of more, the one that has been quiet longest is forgotten.
  static constexpr std::size_t kMostBenches = 64;

  /// Keeps an event among those of its bench, in the order of their ticks. The first one of another
  /// run of the service begins a new history. Of too many, the oldest of the most frequent kind is
  /// forgotten: a bench with late ticks keeps its faults.
  void add(const client::Event& event);

  /// @return the events of a bench, the oldest first; none of a bench without any.
  [[nodiscard]] std::vector<client::Event> events(std::uint32_t bench) const;

 private:
  struct Bench {
    std::uint64_t incarnation = 0;  ///< of `events`
    std::deque<client::Event> events;
    std::map<client::EventKind, std::size_t> counts;  ///< of `events`
    std::uint64_t added = 0;  ///< when the last one was, as a count of all events
  };

  static void forget_one(Bench& bench);

  mutable std::mutex mutex_;  ///< guards what follows
  std::map<std::uint32_t, Bench> benches_;
  std::uint64_t added_ = 0;
};

/// The answer to /events.
/// @throws ProtocolError when the request names no bench
[[nodiscard]] CallAnswer call_events(const EventLog& log, const Json& request);

}  // namespace vdrive::gateway
