// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"

#include <chrono>
#include <cstdint>
#include <string_view>
#include <vector>

namespace vdrive::service {

/// The progress counter of a thread.
struct Beats {
  std::string_view name;  ///< of what it counts, such as "ticks"
  const Counter* count = nullptr;
};

/// @return the counters of `beats`.
[[nodiscard]] std::vector<const Counter*> counts_of(const std::vector<Beats>& beats);

/// Measures how long threads have made no progress. `look` may be called at any interval.
class Standstill {
 public:
  using Clock = std::chrono::steady_clock;

  /// The longest standstill of all threads.
  struct Longest {
    std::string_view name;  ///< of the counter that has not changed for longest
    Clock::duration time{};
  };

  /// @param beats one per thread, at least one, outliving this object
  Standstill(const std::vector<Beats>& beats, Clock::time_point now);

  /// @return the longest standstill, measured from the last call that found progress, so it is
  ///         never overestimated.
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
