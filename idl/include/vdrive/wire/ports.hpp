// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::wire {

/// UDP addresses and ports of the participants of a DDS domain (DDSI-RTPS 2.5, 9.6.1).

/// The multicast group in which participants announce themselves.
inline constexpr const char* kDiscoveryGroup = "239.255.0.1";

/// First port of domain 0, and number of ports per domain.
inline constexpr std::uint32_t kFirstPort = 7'400;
inline constexpr std::uint32_t kPortsOfDomain = 250;

/// The highest domain, 232: ports of the next one would exceed 65535.
inline constexpr std::uint32_t kHighestDomain = (65'535 - kFirstPort) / kPortsOfDomain;

/// @return the DDS domain in the environment variable VDRIVE_DOMAIN, 0 if it is not set.
/// @throws std::runtime_error when it is set to anything but a number from 0 to 232
[[nodiscard]] std::uint32_t default_domain();

/// Number of participants to look for at a peer.
inline constexpr std::uint32_t kParticipantsOfPeer = 32;

/// @return the multicast port of `domain`, which is the first port of that domain.
[[nodiscard]] constexpr std::uint32_t group_port(std::uint32_t domain) noexcept {
  return kFirstPort + kPortsOfDomain * domain;
}

/// @return the port on which participant `number` of a host, from 0, receives announcements.
[[nodiscard]] constexpr std::uint32_t announcement_port(std::uint32_t domain,
                                                        std::uint32_t number) noexcept {
  return group_port(domain) + 10 + 2 * number;
}

}  // namespace vdrive::wire
