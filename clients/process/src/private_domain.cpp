// SPDX-License-Identifier: Apache-2.0
#include "private_domain.hpp"

#include "vdrive/wire/ports.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace vdrive::process {
namespace {

// Above what people use by hand, below the domains whose ports end above the ephemeral range.
constexpr std::uint32_t kFirstDomain = 20;
constexpr std::uint32_t kDomains = 80;

/// Programs that share this machine use the same names: the project's own tests do.
std::filesystem::path lock_file(std::uint32_t domain) {
  return std::filesystem::temp_directory_path() /
         ("vdrive-test-domain-" + std::to_string(domain) + ".lock");
}

/// A socket that does not share its port fails where any other socket has the port: every
/// participant of a domain receives the announcements of the others there.
bool is_unused(std::uint32_t domain) {
  const Descriptor probe(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(wire::group_port(domain)));
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface takes
  return bind(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

/// @return a descriptor that holds the lock, or -1.
int claim(std::uint32_t domain) {
  // NOLINTNEXTLINE(*-vararg): the only interface there is
  const int file = open(lock_file(domain).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) return -1;
  if (flock(file, LOCK_EX | LOCK_NB) == 0 && is_unused(domain)) return file;
  close(file);
  return -1;
}

int claim_any(std::uint32_t& domain) {
  const auto start = static_cast<std::uint32_t>(getpid());
  for (std::uint32_t offset = 0; offset < kDomains; ++offset) {
    domain = kFirstDomain + (start + offset) % kDomains;
    if (const int file = claim(domain); file >= 0) return file;
  }
  throw std::runtime_error("all DDS domains from " + std::to_string(kFirstDomain) + " to " +
                           std::to_string(kFirstDomain + kDomains - 1) + " are in use");
}

}  // namespace

PrivateDomain::PrivateDomain() : lock_(claim_any(number_)) {}

}  // namespace vdrive::process
