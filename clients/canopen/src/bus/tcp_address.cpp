// SPDX-License-Identifier: Apache-2.0
#include "bus/tcp_address.hpp"

#include "vdrive/number_text.hpp"

namespace vdrive::canopen {

std::optional<TcpAddress> parse_tcp_address(std::string_view text) {
  const std::size_t colon = text.rfind(':');  // the last one: an IPv6 address contains others
  if (colon == std::string_view::npos) return std::nullopt;
  const auto port = parse_digits<std::uint16_t>(text.substr(colon + 1));
  std::string_view host = text.substr(0, colon);
  const bool is_bracketed = host.size() >= 2 && host.starts_with('[') && host.ends_with(']');
  if (is_bracketed) host = host.substr(1, host.size() - 2);
  const bool has_colon = host.find(':') != std::string_view::npos;
  if (!port || host.empty() || has_colon != is_bracketed) return std::nullopt;
  // Not resolved: a name server would decide who can reach the bus.
  if (host == "localhost") host = "127.0.0.1";
  return TcpAddress{.host = std::string(host), .port = *port};
}

std::string address_text(const TcpAddress& address) {
  const bool is_ipv6 = address.host.find(':') != std::string::npos;
  const std::string host = is_ipv6 ? "[" + address.host + "]" : address.host;
  return host + ":" + std::to_string(address.port);
}

}  // namespace vdrive::canopen
