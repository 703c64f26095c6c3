// SPDX-License-Identifier: Apache-2.0
// Sends datagrams that no real participant would send.
#pragma once

#include "datagrams.hpp"
#include "support/test_domain.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cstdint>

namespace vdrive::test {

/// Sends to every port that a participant of the domain may have on loopback.
class Attacker {
 public:
  Attacker() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}

  ~Attacker() { close(socket_); }

  Attacker(const Attacker&) = delete;
  Attacker& operator=(const Attacker&) = delete;

  /// @param port counted from the first port of the domain: 10 is for metatraffic, 11 for data of
  ///        participant 0
  void send(const Datagram& datagram, std::uint32_t port) const {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * test_domain() + port));
    static_cast<void>(sendto(socket_, datagram.data(), datagram.size(), 0,
                             std::bit_cast<sockaddr*>(&address), sizeof address));
  }

  void send_to_discovery(const Datagram& datagram) const {
    for (std::uint32_t participant = 0; participant < 16; ++participant) {
      send(datagram, 10 + 2 * participant);
    }
  }

 private:
  int socket_;
};

/// Makes an unguarded Fast DDS participant abort with a failed assertion.
inline Datagram statistics_with_more_behind(const GuidPrefix& sender) {
  Datagram datagram = DatagramWriter(sender).add(0x80, 1, Datagram(56)).bytes();
  datagram.resize(datagram.size() + 4);
  return datagram;
}

/// Makes an unguarded Fast DDS participant spin. The gap must come from the publications of a known
/// participant, because those of others are ignored.
inline Datagram gap_without_end(const GuidPrefix& sender) {
  const std::int64_t far = std::int64_t{1} << 36U;
  return DatagramWriter(sender)
      .add(0x08, 1, gap(kPublicationsReader, kPublicationsWriter, 100, far).bytes())
      .bytes();
}

}  // namespace vdrive::test
