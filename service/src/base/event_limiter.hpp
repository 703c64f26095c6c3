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

/// An event that is let through, and how many equal ones were left out before it.
struct CountedEvent {
  EventRecord event;
  std::uint64_t suppressed = 0;
};

/// Passes a bounded number of equal events and counts the rest. Two events are equal when
/// kind, axis, code and session are.
class EventLimiter {
 public:
  /// An event that is followed by none of its kind for so long leaves no trace; see flush().
  static constexpr std::chrono::seconds kWindow{1};
  static constexpr TokenBucket::Rate kEqual{.per_second = 20.0, .burst = 20.0};
  static constexpr TokenBucket::Rate kAll{.per_second = 8'000.0, .burst = 8'000.0};
  static constexpr std::size_t kMostKinds = 4'096;

  /// Appends to `passed` what may be sent now: this event, or nothing.
  void offer(const EventRecord& event, std::chrono::nanoseconds now,
             std::vector<CountedEvent>& passed);

  /// Appends the last of those events that were left out, once their window is over.
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
  std::uint64_t forgotten_ = 0;  ///< left out, of kinds that are no longer remembered
};

}  // namespace vdrive::service
