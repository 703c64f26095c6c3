// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::canopen {

/// The predefined connection set (CiA 301, 7.3.5): CAN-IDs that no object changes, and the defaults
/// of emergencies. All but that of NMT have the node id added.
inline constexpr std::uint32_t kNmtId = 0x000;
inline constexpr std::uint32_t kSyncId = 0x080;  ///< without a node id
inline constexpr std::uint32_t kEmergencyId = 0x080;
inline constexpr std::uint32_t kSdoResponseId = 0x580;
inline constexpr std::uint32_t kSdoRequestId = 0x600;
inline constexpr std::uint32_t kHeartbeatId = 0x700;  ///< boot-up, too

}  // namespace vdrive::canopen
