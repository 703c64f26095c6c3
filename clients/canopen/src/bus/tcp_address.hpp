// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::canopen {

/// Where a server listens: on loopback unless somebody says otherwise.
struct TcpAddress {
  std::string host = "127.0.0.1";  ///< an address of IPv4 or IPv6
  std::uint16_t port = 0;          ///< 0 = any free one

  friend bool operator==(const TcpAddress&, const TcpAddress&) = default;
};

/// @return the address that `text` spells: "HOST:PORT", where HOST is an address of IPv4, one of
///         IPv6 in brackets, or "localhost", which is 127.0.0.1. Nothing for any other form;
///         whether HOST is an address of this machine shows when a server listens there.
[[nodiscard]] std::optional<TcpAddress> parse_tcp_address(std::string_view text);

/// @return such as "127.0.0.1:29536" or "[::1]:29536".
[[nodiscard]] std::string address_text(const TcpAddress& address);

}  // namespace vdrive::canopen
