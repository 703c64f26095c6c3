// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

namespace vdrive::service {

/// Writes a line to the log of the service. spdlog formats in templates: each source file that
/// calls them compiles the formatter of all types again, 75 KiB. Here the formatter of libfmt is
/// called.
template <typename... Arguments>
void log(spdlog::level::level_enum level, fmt::format_string<Arguments...> format,
         Arguments&&... arguments) {
  if (spdlog::should_log(level)) {
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
