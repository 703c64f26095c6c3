// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace vdrive::service {

/// Reports the state of this process to systemd (sd_notify(3)); does nothing where systemd does not
/// wait for it.
class ServiceManager {
 public:
  /// Reads NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID.
  ServiceManager();

  /// @return half of the time in which it expects a sign of life; nothing = never.
  [[nodiscard]] std::optional<std::chrono::microseconds> heartbeat_interval() const noexcept {
    return heartbeat_interval_;
  }

  /// @return whether only its own network namespace reaches it: the name of its socket
  /// is no file.
  [[nodiscard]] bool receives_in_network() const noexcept { return receives_in_network_; }

  /// @param status a line for people
  void report_ready(const std::string& status) const noexcept;
  void report_status(const std::string& status) const noexcept;
  void report_alive() const noexcept;
  void report_stopping() const noexcept;

 private:
  std::optional<std::chrono::microseconds> heartbeat_interval_;
  bool receives_in_network_ = false;
};

}  // namespace vdrive::service
