// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/token_bucket.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <utility>

namespace vdrive::service {

/// The rate limit of a log line that any sender on the network can provoke.
inline constexpr TokenBucket::Rate kRepeatedLines{.per_second = 1.0, .burst = 1.0};

/// Whether the process is a program of vdrive, which logs to the default logger of spdlog. A bench
/// in a user's process writes no log, because that logger belongs to the user.
[[nodiscard]] inline std::atomic<bool>& is_program_of_vdrive() noexcept {
  static std::atomic<bool> is_program{false};
  return is_program;
}

[[nodiscard]] inline bool is_logged(spdlog::level::level_enum level) noexcept {
  return is_program_of_vdrive().load(std::memory_order_relaxed) && spdlog::should_log(level);
}

/// Writes a line to the log of the service. Formats with libfmt: the templates of spdlog would
/// compile the formatter of all types into each source file that uses them, 75 KiB each.
template <typename... Arguments>
void log(spdlog::level::level_enum level, fmt::format_string<Arguments...> format,
         Arguments&&... arguments) {
  if (is_logged(level)) {
    spdlog::log(level, fmt::format(format, std::forward<Arguments>(arguments)...));
  }
}

template <typename... Arguments>
void log_debug(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  log(spdlog::level::debug, format, std::forward<Arguments>(arguments)...);
}

template <typename... Arguments>
void log_info(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  log(spdlog::level::info, format, std::forward<Arguments>(arguments)...);
}

template <typename... Arguments>
void log_warning(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  log(spdlog::level::warn, format, std::forward<Arguments>(arguments)...);
}

template <typename... Arguments>
void log_error(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  log(spdlog::level::err, format, std::forward<Arguments>(arguments)...);
}

}  // namespace vdrive::service
