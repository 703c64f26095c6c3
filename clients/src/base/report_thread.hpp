// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

namespace vdrive::client {

/// The threads of a session that report to the program. Thread-safe.
class ReportThreads {
 public:
  ReportThreads();
  ~ReportThreads();
  ReportThreads(const ReportThreads&) = delete;
  ReportThreads& operator=(const ReportThreads&) = delete;

  /// Ends every thread and waits for reports in progress. No thread starts after that.
  void end();

 private:
  friend class ReportThread;
  struct Run;

  /// @param reporter nothing = all of them
  void end_runs(std::optional<std::uint64_t> reporter);

  std::mutex mutex_;  ///< guards the members below; never held while waiting for a thread
  std::vector<std::shared_ptr<Run>> runs_;
  bool is_ended_ = false;
};

/// One thread of a session that reports to the program. A report may end or replace its own thread
/// and may destroy this object: the thread then ends after that report. Ending it from any other
/// thread waits for a report in progress. Thread-safe.
class ReportThread {
 public:
  /// Must not report any more once a stop is requested; its own report may request the stop.
  using Work = std::function<void(const std::stop_token&)>;

  explicit ReportThread(ReportThreads& threads);

  ~ReportThread() { stop(); }

  ReportThread(const ReportThread&) = delete;
  ReportThread& operator=(const ReportThread&) = delete;

  /// Starts the thread; a running one is ended first. If two calls start one at the same time, one
  /// thread remains; after the end of the session none starts.
  void start(Work work);

  /// Ends the thread if it is running.
  void stop();

 private:
  ReportThreads& threads_;
  const std::uint64_t number_;  ///< unique in the process
};

}  // namespace vdrive::client
