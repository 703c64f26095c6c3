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

/// Turns SIGINT, SIGTERM and SIGHUP (the terminal was closed) into a call; SIGHUP only if it is not
/// ignored, as it is under nohup(1). Blocks the signals in the calling thread, and thus in threads
/// that it starts later, and waits for them in its own thread; ignores SIGPIPE. A second signal
/// ends the process, unless it is a SIGHUP or follows the first one within 200 ms. Must be created
/// before the first thread.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Calls `action` on a signal, immediately if one has already arrived. Thread-safe.
  void arm(std::function<void()> action);

  /// Calls `action` before a second signal ends the process. Must be called before arm().
  void before_exit(std::function<void()> action);

  /// Once this has returned, no action is called.
  void disarm();

  [[nodiscard]] bool happened() const noexcept { return happened_; }

  /// @return whether SIGTERM or SIGHUP has arrived: there is no user at the keyboard any more.
  [[nodiscard]] bool is_termination() const noexcept { return is_termination_; }

  /// @return whether a signal has arrived since the last call. The next one counts as a first one
  ///         again.
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
  std::chrono::steady_clock::time_point first_;  ///< time of the first signal, used by the thread
                                                 ///< only
  std::jthread thread_;
};

}  // namespace vdrive::tool
