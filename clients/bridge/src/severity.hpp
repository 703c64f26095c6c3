// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::bridge {

/// The level of a report, numbered as in rcl_interfaces/msg/Log.
enum class Severity : std::uint8_t { info = 20, warning = 30, error = 40 };

}  // namespace vdrive::bridge
