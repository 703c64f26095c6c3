// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::bridge {

/// The TCP port of vdrive-gateway, where --listen names no other.
inline constexpr std::uint16_t kGatewayPort = 8765;

}  // namespace vdrive::bridge
