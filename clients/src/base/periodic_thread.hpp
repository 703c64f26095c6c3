// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

namespace vdrive::client {

/// A thread that reports to the program, and that a report may end or replace: it then ends after
/// that report. Not thread-safe; in every other thread its end waits for a report that is under
/// way.
class ReportThread {
 public:
  using Work = std::function<void(const std::stop_token&)>;

  ReportThread() = default;

  ~ReportThread() { stop(); }

  ReportThread(const ReportThread&) = delete;
  ReportThread& operator=(const ReportThread&) = delete;

  /// Starts the thread; one that runs already ends first.
  void start(Work work);

  /// Ends the thread, if it runs.
  void stop();

 private:
  std::jthread thread_;
  std::vector<std::jthread> ended_;  ///< by themselves: another thread waits for them
};

/// A thread that calls a function again and again. Otherwise as ReportThread.
class PeriodicThread {
 public:
  /// @return wall time until the next call; nothing = there is none.
  using Work = std::function<std::optional<std::chrono::milliseconds>()>;

  /// Starts the thread; one that runs already ends first.
  void start(Work work);

  /// Ends the thread, if it runs.
  void stop() { thread_.stop(); }

 private:
  ReportThread thread_;
};

}  // namespace vdrive::client
