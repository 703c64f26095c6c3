// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"
#include "vdrive/token_bucket.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

namespace vdrive::service {

/// An event that passed, and how many equal ones were suppressed before it.
struct CountedEvent {
  EventRecord event;
  std::uint64_t suppressed = 0;
};

/// Limits the rate of equal events and of all events together, and counts the rest. Two events are
/// equal if their kind, axis, code and session are.
class EventLimiter {
 public:
  /// How long equal events are counted together; see flush().
  static constexpr std::chrono::seconds kWindow{1};
  static constexpr TokenBucket::Rate kEqual{.per_second = 20.0, .burst = 20.0};
  static constexpr TokenBucket::Rate kAll{.per_second = 8'000.0, .burst = 8'000.0};
  static constexpr std::size_t kMostKinds = 4'096;

  /// Appends this event to `passed` if it may be sent now.
  void offer(const EventRecord& event, std::chrono::nanoseconds now,
             std::vector<CountedEvent>& passed);

  /// For each window that is over, appends its last suppressed event, with the count of the others.
  void flush(std::chrono::nanoseconds now, std::vector<CountedEvent>& passed);

 private:
  using Key = std::tuple<msg::EventKind, std::uint16_t, std::uint32_t, std::uint64_t>;

  struct Window {
    std::chrono::nanoseconds begin{0};
    CountingLimit limit{kEqual};
    EventRecord last{};
  };

  std::map<Key, Window> windows_;
  TokenBucket all_{kAll};
  std::uint64_t forgotten_ = 0;  ///< suppressed events of windows that were dropped
};

}  // namespace vdrive::service
