// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// The address of a server, on loopback by default.
struct TcpAddress {
  std::string host = "127.0.0.1";  ///< an IPv4 or IPv6 address
  std::uint16_t port = 0;          ///< 0 = any free port

  friend bool operator==(const TcpAddress&, const TcpAddress&) = default;
};

/// @return the address in `text`: "HOST:PORT", where HOST is an IPv4 address, an IPv6 address in
///         brackets, or "localhost", which is 127.0.0.1. Nothing for any other form. Does not check
///         whether HOST is an address of this machine.
[[nodiscard]] std::optional<TcpAddress> parse_tcp_address(std::string_view text);

/// @return such as "127.0.0.1:29536" or "[::1]:29536".
[[nodiscard]] std::string address_text(const TcpAddress& address);

}  // namespace vdrive::canopen
