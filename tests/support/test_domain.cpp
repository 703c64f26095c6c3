// SPDX-License-Identifier: Apache-2.0
#include "support/test_domain.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace vdrive::test {
namespace {

// Above the domains that people use by hand, below the domains whose ports end above the ephemeral
// range.
constexpr std::uint32_t kFirstDomain = 20;
constexpr std::uint32_t kDomains = 80;

bool claim(std::uint32_t domain) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("vdrive-test-domain-" + std::to_string(domain) + ".lock");
  const int descriptor =
      open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);  // NOLINT(*-vararg)
  if (descriptor < 0) return false;
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) {
    return true;  // the lock ends with the process
  }
  close(descriptor);
  return false;
}

std::uint32_t claim_any() {
  const auto start = static_cast<std::uint32_t>(getpid());
  for (std::uint32_t offset = 0; offset < kDomains; ++offset) {
    const std::uint32_t domain = kFirstDomain + (start + offset) % kDomains;
    if (claim(domain)) return domain;
  }
  throw std::runtime_error("every test domain is taken");
}

}  // namespace

std::uint32_t test_domain() {
  static const std::uint32_t domain = claim_any();
  return domain;
}

}  // namespace vdrive::test
