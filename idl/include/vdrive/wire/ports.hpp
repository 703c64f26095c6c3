// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive::wire {

/// Where the participants of a DDS domain are reached by UDP (DDSI-RTPS 2.5, 9.6.1).

/// The group of multicast in which participants announce themselves.
inline constexpr const char* kDiscoveryGroup = "239.255.0.1";

/// Ports of domain 0 begin here, and each domain has so many.
inline constexpr std::uint32_t kFirstPort = 7'400;
inline constexpr std::uint32_t kPortsOfDomain = 250;

/// The highest domain: 232. Ports of the next one are above 65535.
inline constexpr std::uint32_t kHighestDomain = (65'535 - kFirstPort) / kPortsOfDomain;

/// @return the DDS domain that the environment variable VDRIVE_DOMAIN names, 0 when it is not set.
/// @throws std::runtime_error when it is set, but no number from 0 to 232
[[nodiscard]] std::uint32_t default_domain();

/// How many participants of a peer are searched.
inline constexpr std::uint32_t kParticipantsOfPeer = 32;

/// @return the port of the group of `domain`, the first port of that domain.
[[nodiscard]] constexpr std::uint32_t group_port(std::uint32_t domain) noexcept {
  return kFirstPort + kPortsOfDomain * domain;
}

/// @return the port at which participant `number` of a host, from 0, receives announcements.
[[nodiscard]] constexpr std::uint32_t announcement_port(std::uint32_t domain,
                                                        std::uint32_t number) noexcept {
  return group_port(domain) + 10 + 2 * number;
}

}  // namespace vdrive::wire
