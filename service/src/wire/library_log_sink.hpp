// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/library_log.hpp"

#include <cstdint>

namespace vdrive::service {

/// @return a sink that logs at most one line a second, because any sender of packets can make the
///         library print.
[[nodiscard]] wire::LibraryLog::Sink log_of_the_library(std::uint32_t bench);

}  // namespace vdrive::service
