// SPDX-License-Identifier: Apache-2.0
#include "program/service_manager.hpp"

#include "base/log.hpp"

#include <systemd/sd-daemon.h>

#include <cstdlib>
#include <system_error>

namespace vdrive::service {
namespace {

/// Leaves the environment unchanged (argument 0), because each message reads it again.
void notify(const std::string& state) noexcept {
  if (const int result = sd_notify(0, state.c_str()); result < 0) {
    log_warning("NOTIFY_SOCKET: {}", std::generic_category().message(-result));
  }
}

}  // namespace

ServiceManager::ServiceManager() {
  std::uint64_t interval_us = 0;
  if (sd_watchdog_enabled(0, &interval_us) > 0) {
    heartbeat_interval_.emplace(static_cast<std::int64_t>(interval_us / 2));
  }
  const char* const socket = std::getenv("NOTIFY_SOCKET");  // NOLINT(concurrency-mt-unsafe)
  receives_in_network_ = socket != nullptr && *socket == '@';
}

// The library finds the socket in the environment, so these functions need no member of the class.
// NOLINTBEGIN(readability-convert-member-functions-to-static)
void ServiceManager::report_ready(const std::string& status) const noexcept {
  notify("READY=1\nSTATUS=" + status);
}

void ServiceManager::report_status(const std::string& status) const noexcept {
  notify("STATUS=" + status);
}

void ServiceManager::report_alive() const noexcept {
  notify("WATCHDOG=1");
}

void ServiceManager::report_stopping() const noexcept {
  notify("STOPPING=1\nSTATUS=stopping: the axes are braking");
}

// NOLINTEND(readability-convert-member-functions-to-static)

}  // namespace vdrive::service
