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

/// The latest events of each bench, for clients that connect later. Thread-safe.
class EventLog {
 public:
  static constexpr std::size_t kMostOfABench = 1'024;

  /// The most benches with events. Beyond it, the bench that has been quiet longest is forgotten.
  static constexpr std::size_t kMostBenches = 64;

  /// Stores an event with those of its bench, in the order of ticks. The first event after a
  /// restart of the service starts a new history. When there are too many, the oldest event of the
  /// most frequent kind is dropped, so that a bench with late ticks keeps its faults.
  void add(const client::Event& event);

  /// @return the events of a bench, the oldest first; empty if it has none.
  [[nodiscard]] std::vector<client::Event> events(std::uint32_t bench) const;

 private:
  struct Bench {
    std::uint64_t incarnation = 0;  ///< run of the bench that `events` are from
    std::deque<client::Event> events;
    std::map<client::EventKind, std::size_t> counts;  ///< in `events`
    /// Number of its latest event, counted over all benches in order of arrival.
    std::uint64_t added = 0;
  };

  static void forget_one(Bench& bench);

  mutable std::mutex mutex_;  ///< guards the members below
  std::map<std::uint32_t, Bench> benches_;
  std::uint64_t added_ = 0;
};

/// The answer to /events.
/// @throws ProtocolError when the request does not name a bench
[[nodiscard]] CallAnswer call_events(const EventLog& log, const Json& request);

}  // namespace vdrive::gateway
