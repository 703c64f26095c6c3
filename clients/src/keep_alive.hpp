// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "connection.hpp"
#include "holdings.hpp"

#include <mutex>
#include <stop_token>
#include <thread>

namespace vdrive::client {

/// Sends keep-alives, in a thread of its own, to the benches that take axes away from a silent
/// session.
class KeepAliveSender {
 public:
  KeepAliveSender(const Holdings& holdings, Connection& connection)
      : holdings_(holdings), connection_(connection) {}

  /// Starts the thread, once.
  void start();

  /// Ends the thread. Nobody may start it at the same time.
  void stop();

 private:
  void run(const std::stop_token& stop);

  const Holdings& holdings_;
  Connection& connection_;
  std::once_flag started_;
  std::jthread thread_;
};

}  // namespace vdrive::client
