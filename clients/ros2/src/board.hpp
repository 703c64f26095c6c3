// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_motion.hpp"

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// What is published of a bench: its newest state, after the set-points for the ticks behind it
/// were sent.
struct BenchView {
  std::shared_ptr<const client::BenchInfo> info{};
  std::shared_ptr<const std::vector<Joint>> joints{};
  std::shared_ptr<const BenchState> state{};  ///< none while the bench sends no status
  std::shared_ptr<const std::vector<JointLimits>> limits{};
  std::vector<Duty> duties{};
  bool is_enabled = false;
  std::uint64_t session = 0;  ///< of the bridge
  std::string problem{};      ///< why the bridge does not serve the bench; empty = it does
};

/// Hands the views over from the thread that commands to the one that publishes.
class Board {
 public:
  using Views = std::map<std::uint32_t, BenchView>;

  /// @param is_urgent whether the publisher publishes at once
  void put(Views views, bool is_urgent);

  [[nodiscard]] Views views() const;

  /// Waits for new views, at most until `time`.
  void wait_until(std::chrono::steady_clock::time_point time, const std::stop_token& stop);

 private:
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  Views views_;
  bool is_new_ = false;
};

/// @return the time of a tick as ROS has it [ns]: drive time; for a bench in realtime whose drive
///         time differs from the time of day, the time of day.
[[nodiscard]] std::int64_t stamp_of(const client::BenchInfo& bench, std::uint64_t tick);

}  // namespace vdrive::ros2
