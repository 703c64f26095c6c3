// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Boost.Asio, included the same way by every source of vdrive-canopen.

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

/// Cancels the wait for `timer`. cancel() throws only if the timer's service is gone, and no timer
/// here outlives its context, so destructors may call this.
inline void cancel(asio::steady_timer& timer) noexcept {
  try {
    timer.cancel();
  } catch (const boost::system::system_error&) {
  }
}

}  // namespace vdrive::canopen
