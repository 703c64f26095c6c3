// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {

inline constexpr const char* kLoopback = "127.0.0.1";

/// A host and a UDP port.
struct ServerAddress {
  std::string host;        ///< IPv4 address or name
  std::uint16_t port = 0;  ///< 1 to 65535
};

/// An IPv4 address of this host.
struct OwnInterface {
  std::string name;     ///< such as eth0
  std::string address;  ///< such as 10.0.0.1
  bool is_up = false;
};

/// @return whether `text` is an IPv4 address, such as 10.0.0.1.
[[nodiscard]] bool is_address(const std::string& text);

/// @return whether `text` is an IPv4 address or could be a host name, such as bench-0.lab: letters,
///         digits, "-", "_" and ".", with a letter in the last part (RFC 1123, 2.1).
[[nodiscard]] bool is_host(const std::string& text);

/// @return whether `text` is an IPv4 address or could be the name of an interface, such as eth0.
[[nodiscard]] bool is_interface(const std::string& text);

/// @return whether a valid address is a loopback address, 127.0.0.0/8.
[[nodiscard]] bool is_loopback(std::string_view address) noexcept;

/// @return the address in a text such as "10.0.0.9:11811" or "discovery:11811", or nothing.
[[nodiscard]] std::optional<ServerAddress> parse_server_address(std::string_view text);

/// @return the IPv4 addresses of this host.
[[nodiscard]] std::vector<OwnInterface> own_interfaces();

/// @return a text such as "10.0.0.1 (eth0), 127.0.0.1 (lo)".
[[nodiscard]] std::string to_text(const std::vector<OwnInterface>& interfaces);

/// @return the addresses in `own` of `interface`, given as an address or a name, if it is up; empty
///         if there are none.
[[nodiscard]] std::vector<std::string> addresses_of(const std::string& interface,
                                                    const std::vector<OwnInterface>& own);

}  // namespace vdrive::wire
