// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::wire {

/// An address and a port of UDP.
struct ServerAddress {
  std::string address;     ///< IPv4
  std::uint16_t port = 0;  ///< 1 to 65535
};

/// @return whether `text` is an IPv4 address, such as 10.0.0.1.
[[nodiscard]] bool is_address(const std::string& text);

/// @return whether a valid address is of this host's loopback, 127.0.0.0/8.
[[nodiscard]] bool is_loopback(std::string_view address) noexcept;

/// @return what `text` such as "10.0.0.9:11811" names, or nothing.
[[nodiscard]] std::optional<ServerAddress> parse_server_address(std::string_view text);

}  // namespace vdrive::wire
