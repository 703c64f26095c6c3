// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/address.hpp"

#include "vdrive/number_text.hpp"

#include <arpa/inet.h>

namespace vdrive::wire {

bool is_address(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

bool is_loopback(std::string_view address) noexcept {
  return address.starts_with("127.");
}

std::optional<ServerAddress> parse_server_address(std::string_view text) {
  const auto colon = text.find(':');
  const std::string address(text.substr(0, colon));
  if (colon == std::string_view::npos || !is_address(address)) return std::nullopt;
  const auto port = parse_digits<std::uint16_t>(text.substr(colon + 1));
  if (!port || *port == 0) return std::nullopt;
  return ServerAddress{address, *port};
}

}  // namespace vdrive::wire
