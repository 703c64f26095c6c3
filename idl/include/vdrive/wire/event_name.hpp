// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace vdrive::wire {

/// @return the name of an EVENT_ constant, such as "fault_reset"; "unknown" for any other number.
[[nodiscard]] std::string_view event_name(std::uint32_t kind) noexcept;

}  // namespace vdrive::wire
