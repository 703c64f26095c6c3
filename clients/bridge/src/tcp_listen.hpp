// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/text.hpp"

#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>

#include <cstdint>
#include <stdexcept>
#include <string>

namespace vdrive::bridge {

/// Opens `acceptor`, which then listens for TCP connections.
/// @param host an address of IPv4 or IPv6
/// @param port 0 = any free one
/// @param place how messages call both
/// @throws std::runtime_error when `host` is no address, or when nobody can listen there
inline void listen_on(boost::asio::ip::tcp::acceptor& acceptor, const std::string& host,
                      std::uint16_t port, const std::string& place) {
  boost::system::error_code problem;
  const auto address = boost::asio::ip::make_address(host, problem);
  if (problem) {
    throw std::runtime_error("cannot listen on " + in_quotes(host) +
                             ": it is not an address of a network");
  }
  const boost::asio::ip::tcp::endpoint endpoint(address, port);
  try {
    acceptor.open(endpoint.protocol());
    // Else a program that is started again cannot listen while the kernel keeps connections of the
    // one before.
    acceptor.set_option(boost::asio::socket_base::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen();
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error("cannot listen on " + place + ": " + error.code().message());
  }
}

}  // namespace vdrive::bridge
