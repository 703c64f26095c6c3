// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>

namespace vdrive::bridge {

/// What waits to be asked of the drive of one axis, in order. Bounded, and what was asked for last
/// reaches the drive: where a world asks faster than a bench answers, a job that changes the drive
/// takes the place of the oldest one of its kind.
class AxisJobs {
 public:
  /// kAccess, or a kind of jobs that change the drive, whose numbers the bridge chooses.
  using Kind = std::uint8_t;

  /// Has an answer, and is refused where too many wait.
  static constexpr Kind kAccess = 0;

  using Job = std::function<void()>;

  /// Jobs that may wait, and one more of each kind that changes the drive.
  static constexpr std::size_t kMost = 64;

  /// @return false when the job was refused.
  [[nodiscard]] bool add(Kind kind, Job job) {
    if (jobs_.size() >= kMost) {
      if (kind == kAccess) return false;
      const auto older = std::ranges::find(jobs_, kind, &Waiting::kind);
      if (older != jobs_.end()) jobs_.erase(older);
    }
    jobs_.push_back({.kind = kind, .job = std::move(job)});
    return true;
  }

  /// @return the oldest job. @pre there is one
  [[nodiscard]] Job take() {
    ensure(!jobs_.empty(), "a job waits");
    Job job = std::move(jobs_.front().job);
    jobs_.pop_front();
    return job;
  }

  [[nodiscard]] bool is_empty() const noexcept { return jobs_.empty(); }

 private:
  struct Waiting {
    Kind kind = kAccess;
    Job job;
  };

  std::deque<Waiting> jobs_;
};

}  // namespace vdrive::bridge
