// SPDX-License-Identifier: Apache-2.0
#include "vdrive/text.hpp"
#include "vdrive/wire/ports.hpp"

#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace vdrive::wire {

std::uint32_t default_domain() {
  const char* const text =
      std::getenv("VDRIVE_DOMAIN");  // NOLINT(concurrency-mt-unsafe): read only
  if (text == nullptr) return 0;
  const std::string_view digits(text);
  if (digits.empty()) {
    throw std::runtime_error(
        "VDRIVE_DOMAIN in the environment is set, but empty: unset it or give a value");
  }
  std::uint32_t domain = 0;
  const auto [end, error] = std::from_chars(digits.begin(), digits.end(), domain);
  if (error == std::errc() && end == digits.end() && domain <= kHighestDomain) return domain;
  throw std::runtime_error("VDRIVE_DOMAIN in the environment is " + in_quotes(digits) +
                           ": a DDS domain must be a number from 0 to " +
                           std::to_string(kHighestDomain));
}

}  // namespace vdrive::wire
