// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"

#include <chrono>
#include <cstdint>
#include <string_view>
#include <vector>

namespace vdrive::service {

/// What a thread has completed.
struct Beats {
  std::string_view name;  ///< such as "ticks"
  const Counter* count = nullptr;
};

/// @return the counters of `beats`.
[[nodiscard]] std::vector<const Counter*> counts_of(const std::vector<Beats>& beats);

/// For how long threads have made no progress, for one who looks at any time, rarely or often.
class Standstill {
 public:
  using Clock = std::chrono::steady_clock;

  /// What was looked at last.
  struct Longest {
    std::string_view name;  ///< of the thread that has stood still for longest
    Clock::duration time{};
  };

  /// @param beats one for each thread, at least one, outliving this object
  Standstill(const std::vector<Beats>& beats, Clock::time_point now);

  /// @return counted from the last look that found progress, so never too long.
  [[nodiscard]] Longest look(Clock::time_point now);

 private:
  struct Watched {
    Beats beats;
    std::uint64_t seen = 0;
    Clock::time_point since;
  };

  std::vector<Watched> watched_;
};

}  // namespace vdrive::service
