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

/// A thread that does one thing after the other: calls to benches wait, and no other thread waits
/// for them. Its thread starts with the first job.
class Worker {
 public:
  /// Jobs that may wait: a client that sends more than its bench answers hears of it.
  static constexpr std::size_t kMostJobs = 64;

  /// @param most_jobs that wait
  explicit Worker(std::size_t most_jobs = kMostJobs) : jobs_(most_jobs, WhenFull::refuses_newest) {}

  /// Waits for the job under way; the others are dropped.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Any thread. @return false when too many jobs wait, or after close().
  [[nodiscard]] bool post(std::function<void()> job);

  /// Ends after the job under way; the other jobs are dropped. Does not wait.
  void close();

  /// @return whether the thread has ended, or never was.
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
