// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::bridge {

/// The default TCP port of vdrive-gateway (--listen).
inline constexpr std::uint16_t kGatewayPort = 8765;

}  // namespace vdrive::bridge
