// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive/bounded_queue.hpp"
#include "vdrive_messages.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>

namespace vdrive::client {

/// Passes new events only. A reader gets the last 1,024 events of a bench when it joins, and again
/// when the wire process of its service restarts. Not thread-safe.
class EventFilter {
 public:
  /// As many as a service sends again.
  static constexpr std::size_t kRemembered = 1'024;

  /// Starts a run: its events before `tick` are history.
  void begin(const BenchKey& key, std::uint64_t tick) {
    // An earlier run of the bench sends no more events.
    std::erase_if(runs_, [&key](const auto& item) {
      return item.first.number == key.number && item.first.incarnation < key.incarnation;
    });
    runs_.try_emplace(key, Run{.first_tick = tick});
  }

  [[nodiscard]] bool knows(const BenchKey& key) const { return runs_.contains(key); }

  /// @return whether the event belongs to a known run and is neither history nor a repetition.
  [[nodiscard]] bool passes(const msg::Event& event) {
    const auto found = runs_.find({event.bench, event.incarnation});
    if (found == runs_.end() || event.tick < found->second.first_tick) return false;
    auto& passed = found->second.passed;
    if (std::ranges::find(passed.items(), event) != passed.items().end()) return false;
    return passed.put(event);
  }

 private:
  struct Run {
    std::uint64_t first_tick = 0;
    BoundedQueue<msg::Event> passed{kRemembered, WhenFull::drops_oldest};
  };

  std::map<BenchKey, Run> runs_;
};

}  // namespace vdrive::client
