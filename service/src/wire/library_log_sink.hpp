// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/library_log.hpp"

#include <cstdint>

namespace vdrive::service {

/// @return a sink that logs a line a second, whatever arrives: what the library prints of a packet
///         is the sender's to choose.
[[nodiscard]] wire::LibraryLog::Sink log_of_the_library(std::uint32_t bench);

}  // namespace vdrive::service
