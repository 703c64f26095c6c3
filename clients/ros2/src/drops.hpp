// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reports.hpp"
#include "vdrive/wire/guard.hpp"

#include <chrono>
#include <string>

namespace vdrive::ros2 {

/// Reports datagrams that do not reach the bridge because the guard refuses them.
class Drops {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Drops(bridge::Reports& reports) : reports_(reports) {}

  /// Reports what was refused since the last report, at most once per second.
  /// @param counts of the participant
  void report(const wire::GuardCounts& counts, Clock::time_point now);

 private:
  bridge::Reports& reports_;
  wire::GuardCounts reported_{};
  Clock::time_point due_{};
};

/// @param words a message from the log of the DDS library
/// @return a readable form of it if it says that a message is larger than its reader accepts;
///         otherwise `words`.
[[nodiscard]] std::string dropped_message(const std::string& words);

}  // namespace vdrive::ros2
