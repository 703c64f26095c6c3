// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reports.hpp"
#include "vdrive/wire/guard.hpp"

#include <chrono>
#include <string>

namespace vdrive::ros2 {

/// Reports what does not reach the bridge: datagrams that the guard refuses.
class Drops {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Drops(bridge::Reports& reports) : reports_(reports) {}

  /// Reports what was refused since the last report, at most once a second.
  /// @param counts of the participant
  void report(const wire::GuardCounts& counts, Clock::time_point now);

 private:
  bridge::Reports& reports_;
  wire::GuardCounts reported_{};
  Clock::time_point due_{};
};

/// @param words of the log of the DDS library
/// @return the same for a person where it says that a message is larger than its reader takes.
[[nodiscard]] std::string dropped_message(const std::string& words);

}  // namespace vdrive::ros2
