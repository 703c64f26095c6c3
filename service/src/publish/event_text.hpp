// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"

#include <spdlog/common.h>

#include <cstdint>
#include <string>

namespace vdrive::service {

/// @return a description of the event, at most 200 bytes.
[[nodiscard]] std::string words_of(const EventRecord& event);

/// @return the log level of the event.
[[nodiscard]] spdlog::level::level_enum level_of(const EventRecord& event);

/// @return the event as a log line: key=value pairs, the description last.
/// @param suppressed number of equal events suppressed before it
[[nodiscard]] std::string log_line(std::uint32_t bench, const EventRecord& event,
                                   std::uint64_t suppressed);

}  // namespace vdrive::service
