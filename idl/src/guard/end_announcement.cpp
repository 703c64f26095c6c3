// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/end_announcement.hpp"

#include "announcement.hpp"
#include "vdrive/wire/address.hpp"
#include "vdrive/wire/ports.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <string>
#include <vector>

namespace vdrive::wire {
namespace {

constexpr int kTimes = 3;  // datagrams get lost

/// A socket for sending.
class Sender {
 public:
  Sender() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    if (socket_ < 0) {
      throw NetworkError("cannot open a socket to announce the end of a dead participant");
    }
  }

  ~Sender() { close(socket_); }

  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  /// Sends multicast from `interface` from now on.
  /// @return false if it is not an address of this host from which multicast can be sent.
  [[nodiscard]] bool set_multicast_interface(const std::string& interface) const {
    in_addr address{};
    return inet_pton(AF_INET, interface.c_str(), &address) == 1 &&
           setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_IF, &address, sizeof address) == 0;
  }

  // Ignores errors: an unreachable address must not keep the others from being told. Does not
  // resolve names, which would mean waiting for a name server; participants on hosts given by name
  // detect the end by silence.
  void send(const std::string& to, std::uint32_t port,
            const std::vector<std::uint8_t>& datagram) const {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    if (inet_pton(AF_INET, to.c_str(), &address.sin_addr) == 1) {
      static_cast<void>(sendto(socket_, datagram.data(), datagram.size(), MSG_DONTWAIT,
                               std::bit_cast<sockaddr*>(&address), sizeof address));
    }
  }

 private:
  int socket_;
};

}  // namespace

void announce_end(const NetworkSettings& settings, const Source& dead) {
  if (!settings.discovery_servers.empty()) return;
  const Sender sender;
  const auto datagram = end_datagram(dead.participant);
  std::vector<std::string> interfaces{kLoopback};
  const std::vector<OwnInterface> own = own_interfaces();
  for (const auto& interface : settings.interfaces) {
    std::ranges::copy(addresses_of(interface, own), std::back_inserter(interfaces));
  }
  for (int time = 0; time < kTimes; ++time) {
    for (const auto& interface : interfaces) {
      if (sender.set_multicast_interface(interface)) {
        sender.send(kDiscoveryGroup, group_port(settings.domain), datagram);
      }
    }
    for (const auto& peer : settings.peers) {
      for (std::uint32_t participant = 0; participant < kParticipantsOfPeer; ++participant) {
        sender.send(peer, announcement_port(settings.domain, participant), datagram);
      }
    }
  }
}

}  // namespace vdrive::wire
