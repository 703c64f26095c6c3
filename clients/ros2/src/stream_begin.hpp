// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>

namespace vdrive::ros2 {

/// @return the mode in which a drive follows set-points of this interface.
[[nodiscard]] OperatingMode mode_of(CommandInterface interface) noexcept;

/// @return what an axis gets before a stream, or with its first set-point: its mode (6060h), and 0
///         in 60C2h:01, 60B0h, 60B1h and 60B2h.
[[nodiscard]] client::SetPoint begin_stream(std::uint16_t axis, OperatingMode mode);

}  // namespace vdrive::ros2
