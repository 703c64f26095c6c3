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

/// Jobs waiting for the drive of one axis, in order. Bounded, and the latest request always reaches
/// the drive: if requests arrive faster than a bench answers, a job that changes the drive replaces
/// the oldest one of its kind.
class AxisJobs {
 public:
  /// kAccess, or a kind of jobs that change the drive; the bridge chooses the numbers.
  using Kind = std::uint8_t;

  /// Jobs that have an answer; refused if too many are waiting.
  static constexpr Kind kAccess = 0;

  using Job = std::function<void()>;

  /// Maximum number of waiting jobs; each kind that changes the drive may exceed it by one job.
  static constexpr std::size_t kMost = 64;

  /// @return false if the job was refused.
  [[nodiscard]] bool add(Kind kind, Job job) {
    if (jobs_.size() >= kMost) {
      if (kind == kAccess) return false;
      const auto older = std::ranges::find(jobs_, kind, &Waiting::kind);
      if (older != jobs_.end()) jobs_.erase(older);
    }
    jobs_.push_back({.kind = kind, .job = std::move(job)});
    return true;
  }

  /// @return the oldest job.
  /// @pre there is one
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
