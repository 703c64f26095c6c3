// SPDX-License-Identifier: Apache-2.0
#include "bridge/drive_jobs.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::canopen {

bool DriveJobs::add(Kind kind, Job job) {
  if (jobs_.size() >= kMost) {
    if (kind == Kind::access) return false;
    const auto older = std::ranges::find(jobs_, kind, &Waiting::kind);
    if (older != jobs_.end()) jobs_.erase(older);
  }
  jobs_.push_back({.kind = kind, .job = std::move(job)});
  return true;
}

DriveJobs::Job DriveJobs::take() {
  ensure(!jobs_.empty(), "a job waits");
  Job job = std::move(jobs_.front().job);
  jobs_.pop_front();
  return job;
}

}  // namespace vdrive::canopen
