// SPDX-License-Identifier: Apache-2.0
#include "private_domain.hpp"

#include "vdrive/number_text.hpp"
#include "vdrive/wire/ports.hpp"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace vdrive::process {
namespace {

using Domains = std::set<std::uint32_t>;

/// The owners of the ports: for each user, the domain of each of the user's sockets.
using Holders = std::map<uid_t, std::multiset<std::uint32_t>>;

/// Adds the user and the domain of a socket if its port is the group port of one of our domains.
void note_socket(const std::string& line, Holders& holders) {
  constexpr int kHex = 16;
  constexpr int kBeforeUser = 5;  // columns to skip
  std::istringstream fields(line);
  std::string number;
  std::string local;
  std::string skipped;
  uid_t user = 0;
  fields >> number >> local;
  for (int i = 0; i < kBeforeUser; ++i) fields >> skipped;
  fields >> user;
  const std::size_t colon = local.find(':');
  if (!fields || colon == std::string::npos) return;
  const auto port = parse_digits<std::uint32_t>(std::string_view(local).substr(colon + 1), kHex);
  for (std::uint32_t i = 0; i < PrivateDomain::kCount; ++i) {
    const std::uint32_t domain = PrivateDomain::kFirst + i;
    if (port == wire::group_port(domain)) holders[user].insert(domain);
  }
}

/// @return the sockets listed by the system, which any user can read.
Holders holders_of_domains() {
  Holders holders;
  for (const char* const file : {"/proc/net/udp", "/proc/net/udp6"}) {
    std::ifstream sockets(file);
    std::string line;
    std::getline(sockets, line);  // column headings
    while (std::getline(sockets, line)) note_socket(line, holders);
  }
  return holders;
}

std::size_t count_domains(const std::multiset<std::uint32_t>& sockets) {
  return Domains(sockets.begin(), sockets.end()).size();
}

std::string text_of(const Holders& holders) {
  std::string text;
  for (const auto& [user, sockets] : holders) {
    text += (text.empty() ? "" : ", ") + std::to_string(count_domains(sockets)) + " by user " +
            std::to_string(user);
  }
  return text;
}

sockaddr_in address_of(in_addr_t host, std::uint32_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(host);
  return address;
}

/// Switches sharing of the port on or off.
void share(int claim, bool is_shared) {
  const int value = is_shared ? 1 : 0;
  if (setsockopt(claim, SOL_SOCKET, SO_REUSEADDR, &value, sizeof value) == 0) return;
  throw std::system_error(errno, std::generic_category(), "socket of a DDS domain");
}

/// Binds a socket to the port at which participants of the domain announce themselves.
/// @param is_shared whether another socket that shares the port may already be bound to it
/// @return the socket, or -1.
int claim(std::uint32_t domain, bool is_shared) {
  const int claim = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (claim < 0) throw std::system_error(errno, std::generic_category(), "socket");
  share(claim, is_shared);
  const sockaddr_in group = address_of(INADDR_ANY, wire::group_port(domain));
  // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface takes
  if (bind(claim, reinterpret_cast<const sockaddr*>(&group), sizeof group) != 0) {
    close(claim);
    return -1;
  }
  // Participants of the domain share the port and must get the messages sent to it. So this socket
  // is connected to a peer that never sends: a port of the domain that RTPS does not use.
  constexpr std::uint32_t kUnusedPort = 9;
  share(claim, true);
  const sockaddr_in nobody = address_of(INADDR_LOOPBACK, wire::group_port(domain) + kUnusedPort);
  // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface takes
  static_cast<void>(connect(claim, reinterpret_cast<const sockaddr*>(&nobody), sizeof nobody));
  return claim;
}

/// @return another user with more domains than one user is entitled to.
std::optional<uid_t> squatter_of(const Holders& holders) {
  const auto squatter = std::ranges::find_if(holders, [](const auto& holder) {
    return holder.first != geteuid() &&
           count_domains(holder.second) > PrivateDomain::kMostOfOneUser;
  });
  if (squatter == holders.end()) return std::nullopt;
  return squatter->first;
}

/// @return the number of sockets of users other than `user` on the port of the domain.
std::size_t others(const Holders& holders, uid_t user, std::uint32_t domain) {
  std::size_t count = 0;
  for (const auto& [holder, sockets] : holders) {
    if (holder != user) count += sockets.count(domain);
  }
  return count;
}

/// Shares the domain with a user who has too many domains, and with nobody else.
int share_with(uid_t squatter, std::uint32_t domain) {
  if (others(holders_of_domains(), squatter, domain) != 0) return -1;
  const int claimed = claim(domain, true);
  // If two programs claim it at the same time, both see each other, and both go on to another
  // domain.
  if (claimed < 0 || others(holders_of_domains(), squatter, domain) == 1) return claimed;
  close(claimed);
  return -1;
}

/// Tries one domain after another; each process starts at a different one.
template <typename Claim>
int claim_first(std::uint32_t& domain, const Claim& claim_one) {
  const auto start = static_cast<std::uint32_t>(getpid());
  for (std::uint32_t offset = 0; offset < PrivateDomain::kCount; ++offset) {
    domain = PrivateDomain::kFirst + (start + offset) % PrivateDomain::kCount;
    if (const int claimed = claim_one(domain); claimed >= 0) return claimed;
  }
  return -1;
}

int claim_any(std::uint32_t& domain) {
  const std::string range = std::to_string(PrivateDomain::kFirst) + " to " +
                            std::to_string(PrivateDomain::kFirst + PrivateDomain::kCount - 1);
  Holders holders = holders_of_domains();
  if (count_domains(holders[geteuid()]) >= PrivateDomain::kMostOfOneUser) {
    throw std::runtime_error("this user has " + std::to_string(PrivateDomain::kMostOfOneUser) +
                             " of the DDS domains " + range + ", the limit for one user");
  }
  const int free = claim_first(domain, [](std::uint32_t one) {
    return claim(one, false);
  });
  if (free >= 0) return free;
  holders = holders_of_domains();
  if (const auto squatter = squatter_of(holders)) {
    const int shared = claim_first(domain, [&squatter](std::uint32_t one) {
      return share_with(*squatter, one);
    });
    if (shared >= 0) return shared;
  }
  throw std::runtime_error("all DDS domains from " + range + " are in use: " + text_of(holders));
}

}  // namespace

PrivateDomain::PrivateDomain() : claim_(claim_any(number_)) {}

}  // namespace vdrive::process
