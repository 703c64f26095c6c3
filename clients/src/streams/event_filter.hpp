// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/directory.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>

namespace vdrive::client {

/// Which events are new. A reader gets the last 1,024 events of a bench when it joins, and again
/// when the network process of its service restarts. Not thread-safe.
class EventFilter {
 public:
  /// As many as a service sends again.
  static constexpr std::size_t kRemembered = 1'024;

  /// Events of this run before `tick` are history.
  void begin(const BenchKey& key, std::uint64_t tick);

  [[nodiscard]] bool knows(const BenchKey& key) const { return runs_.contains(key); }

  /// @return whether the event of a known run is neither history nor known.
  [[nodiscard]] bool passes(const msg::Event& event);

 private:
  struct Run {
    std::uint64_t first_tick = 0;
    std::deque<msg::Event> passed;  ///< oldest first
  };

  std::map<BenchKey, Run> runs_;
};

}  // namespace vdrive::client
