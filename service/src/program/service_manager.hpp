// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace vdrive::service {

/// Reports the state of this process to systemd (sd_notify(3)); does nothing if systemd does not
/// expect reports.
class ServiceManager {
 public:
  /// Reads NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID.
  ServiceManager();

  /// @return half of the time within which systemd expects a heartbeat; nullopt = it expects none.
  [[nodiscard]] std::optional<std::chrono::microseconds> heartbeat_interval() const noexcept {
    return heartbeat_interval_;
  }

  /// @return whether systemd can only be reached from its own network namespace, because its socket
  ///         is abstract and not a file.
  [[nodiscard]] bool receives_in_network() const noexcept { return receives_in_network_; }

  /// @param status one line for display
  void report_ready(const std::string& status) const noexcept;
  void report_status(const std::string& status) const noexcept;
  void report_alive() const noexcept;
  void report_stopping() const noexcept;

 private:
  std::optional<std::chrono::microseconds> heartbeat_interval_;
  bool receives_in_network_ = false;
};

}  // namespace vdrive::service
