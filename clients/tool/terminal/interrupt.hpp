// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <csignal>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace vdrive::tool {

/// Turns SIGINT, SIGTERM and SIGHUP (its terminal was closed) into a call; SIGHUP not where it is
/// ignored, as under nohup(1). Blocks them in the calling thread, whose later threads inherit that,
/// and waits for them in a thread of its own; ignores SIGPIPE. A second signal ends the process,
/// unless it is a SIGHUP or comes within 200 ms of the first one. To be made before the first
/// thread.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Calls `action` on a signal, also when it has come already. Any thread.
  void arm(std::function<void()> action);

  /// Calls `action` before a second signal ends the process. To be set before arm().
  void before_exit(std::function<void()> action);

  /// No call from here on.
  void disarm();

  [[nodiscard]] bool happened() const noexcept { return happened_; }

  /// @return whether SIGTERM or SIGHUP has come: nobody types any more.
  [[nodiscard]] bool is_termination() const noexcept { return is_termination_; }

  /// @return whether a signal has come since the last call. The next one is a first one again.
  bool take() noexcept { return happened_.exchange(false); }

 private:
  void wait(const std::stop_token& stop);
  void note(int signal);

  sigset_t signals_{};
  std::atomic<bool> happened_ = false;
  std::atomic<bool> is_termination_ = false;
  std::mutex mutex_;
  std::function<void()> action_;
  std::function<void()> last_action_;
  std::chrono::steady_clock::time_point first_;  ///< signal, of its thread
  std::jthread thread_;
};

}  // namespace vdrive::tool
