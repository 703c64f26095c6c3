// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/frame.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace vdrive::canopen {

/// The predefined connection set (CiA 301, 7.3.5): CAN-IDs that no object changes, and the defaults
/// of SYNC and emergencies. The node id is added to all of them except NMT and SYNC.
inline constexpr std::uint32_t kNmtId = 0x000;
inline constexpr std::uint32_t kSyncId = 0x080;
inline constexpr std::uint32_t kEmergencyId = 0x080;
inline constexpr std::uint32_t kSdoResponseId = 0x580;
inline constexpr std::uint32_t kSdoRequestId = 0x600;
inline constexpr std::uint32_t kHeartbeatId = 0x700;  ///< also of the boot-up message

// A COB-ID as an object stores it: the CAN-ID in bits 0 to 10, flags above (CiA 301, 7.5.2.5,
// 7.5.2.17, 7.5.2.35 and 7.5.2.37).
inline constexpr std::uint32_t kCobIdNotValid = 0x80000000;  ///< PDO, EMCY: does not exist
inline constexpr std::uint32_t kCobIdNoRemote = 0x40000000;  ///< TPDO: remote frames are not
                                                             ///< answered
inline constexpr std::uint32_t kCobIdProducer = 0x40000000;  ///< SYNC: the node generates it

/// The flag of the extended format, and the bits that only an extended CAN-ID has. These nodes use
/// the base format: all of these bits are 0.
inline constexpr std::uint32_t kCobIdExtendedBits = 0x3FFFF800;

struct CanIdRange {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};

/// CAN-IDs that no configurable communication object may use (CiA 301, 7.3.5, table "Restricted
/// CAN-IDs").
inline constexpr std::array kRestrictedCanIds{
    CanIdRange{0x000, 0x000},  // NMT
    CanIdRange{0x001, 0x07F},  // reserved
    CanIdRange{0x101, 0x180},  // reserved
    CanIdRange{0x581, 0x5FF},  // default SDO, server to client
    CanIdRange{0x601, 0x67F},  // default SDO, client to server
    CanIdRange{0x6E0, 0x6FF},  // reserved
    CanIdRange{0x701, 0x77F},  // NMT error control
    CanIdRange{0x780, 0x7FF},  // reserved
};

[[nodiscard]] constexpr bool is_restricted_can_id(std::uint32_t can_id) noexcept {
  return std::ranges::any_of(kRestrictedCanIds, [can_id](const CanIdRange& range) {
    return range.first <= can_id && can_id <= range.last;
  });
}

[[nodiscard]] constexpr std::uint32_t can_id_of(std::uint32_t cob_id) noexcept {
  return cob_id & kHighestBaseId;
}

}  // namespace vdrive::canopen
