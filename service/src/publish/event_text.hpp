// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/event_record.hpp"

#include <spdlog/common.h>

#include <cstdint>
#include <string>

namespace vdrive::service {

/// @return what happened, in words; at most 200 bytes.
[[nodiscard]] std::string words_of(const EventRecord& event);

/// @return how loud the log tells of it.
[[nodiscard]] spdlog::level::level_enum level_of(const EventRecord& event);

/// @return what happened as a line of a log: key=value pairs, the words last.
/// @param suppressed equal events left out before it
[[nodiscard]] std::string log_line(std::uint32_t bench, const EventRecord& event,
                                   std::uint64_t suppressed);

}  // namespace vdrive::service
