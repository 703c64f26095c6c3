// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/token_bucket.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <utility>

namespace vdrive::service {

/// Of a line of the log that whoever sends to the service can repeat.
inline constexpr TokenBucket::Rate kRepeatedLines{.per_second = 1.0, .burst = 1.0};

/// Whether the process is a program of vdrive, whose log goes to the default logger of spdlog. In
/// the process of a user a bench writes no log: that logger is the user's.
[[nodiscard]] inline std::atomic<bool>& is_program_of_vdrive() noexcept {
  static std::atomic<bool> is_program{false};
  return is_program;
}

[[nodiscard]] inline bool is_logged(spdlog::level::level_enum level) noexcept {
  return is_program_of_vdrive().load(std::memory_order_relaxed) && spdlog::should_log(level);
}

/// Writes a line to the log of the service. spdlog formats in templates: each source file that
/// calls them compiles the formatter of all types again, 75 KiB. Here the formatter of libfmt is
/// called.
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
