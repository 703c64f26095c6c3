// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Boost.Asio as every source of vdrive-canopen reads it.

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/system/system_error.hpp>

namespace vdrive::canopen {

namespace asio = boost::asio;
using asio::ip::tcp;
using AsioError = boost::system::error_code;

/// Ends the wait for `timer`. That fails only for a timer whose service is gone, and here no timer
/// outlives its context: destructors may call it.
inline void cancel(asio::steady_timer& timer) noexcept {
  try {
    timer.cancel();
  } catch (const boost::system::system_error&) {
  }
}

}  // namespace vdrive::canopen
