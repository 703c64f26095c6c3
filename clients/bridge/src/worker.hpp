// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/bounded_queue.hpp"

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>

namespace vdrive::bridge {

/// A thread that runs one job after another, such as calls that wait for a bench, so that no other
/// thread has to wait. The thread starts with the first job.
class Worker {
 public:
  /// Maximum number of waiting jobs: a client that sends faster than its bench answers is told so.
  static constexpr std::size_t kMostJobs = 64;

  /// @param most_jobs that may wait
  explicit Worker(std::size_t most_jobs = kMostJobs) : jobs_(most_jobs, WhenFull::refuses_newest) {}

  /// Waits for the job in progress; the others are dropped.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Any thread.
  /// @return false if too many jobs are waiting, or after close().
  [[nodiscard]] bool post(std::function<void()> job);

  /// Ends after the job in progress; the other jobs are dropped. Does not wait.
  void close();

  /// @return whether the thread has ended, or never started.
  [[nodiscard]] bool has_ended() const noexcept { return has_ended_; }

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable changed_;
  BoundedQueue<std::function<void()>> jobs_;
  bool is_closed_ = false;
  std::atomic<bool> has_ended_ = true;
  std::thread thread_;
};

}  // namespace vdrive::bridge
