// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_limits.hpp"
#include "joints.hpp"
#include "vdrive/client/axis.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace vdrive::ros2 {

/// The limits of the joints of a bench, as the drives have them: read when somebody asks, and every
/// two seconds, because other programs change them. read() is for the thread that may wait.
class LimitsReader {
 public:
  using Clock = std::chrono::steady_clock;
  using Limits = std::shared_ptr<const std::vector<JointLimits>>;

  /// @return the limits of all joints; none before they were read.
  [[nodiscard]] Limits limits() const;

  /// Has them read again. @return the value that count() has after it.
  std::uint64_t request() { return ++requested_; }

  [[nodiscard]] std::uint64_t count() const noexcept { return read_; }

  [[nodiscard]] bool is_due(Clock::time_point now) const {
    return requested_ != read_ || now >= due_;
  }

  /// Reads all of them, or none when one cannot be read: then it is due again after the period.
  /// @param axes those of the joints, in their order
  /// @return whether they were read
  bool read(const std::vector<client::Axis>& axes, const std::vector<Joint>& joints,
            Clock::time_point now);

 private:
  Clock::time_point due_{};
  std::atomic<std::uint64_t> requested_ = 0;
  std::atomic<std::uint64_t> read_ = 0;
  mutable std::mutex mutex_;  ///< guards what follows
  Limits limits_;
};

}  // namespace vdrive::ros2
