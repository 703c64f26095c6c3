// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/text.hpp"

#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>

#include <cstdint>
#include <stdexcept>
#include <string>

namespace vdrive::bridge {

/// Opens `acceptor` and listens for TCP connections.
/// @param host an IPv4 or IPv6 address
/// @param port 0 = any free one
/// @param place host and port as written in messages
/// @throws std::runtime_error if `host` is not an address, or if it is not possible to listen there
inline void listen_on(boost::asio::ip::tcp::acceptor& acceptor, const std::string& host,
                      std::uint16_t port, const std::string& place) {
  boost::system::error_code problem;
  const auto address = boost::asio::ip::make_address(host, problem);
  if (problem) {
    throw std::runtime_error("cannot listen on " + in_quotes(host) + ": it is not an IP address");
  }
  const boost::asio::ip::tcp::endpoint endpoint(address, port);
  try {
    acceptor.open(endpoint.protocol());
    // Otherwise a restarted program could not listen while the kernel still holds connections of
    // the previous one.
    acceptor.set_option(boost::asio::socket_base::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen();
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error("cannot listen on " + place + ": " + error.code().message());
  }
}

}  // namespace vdrive::bridge
