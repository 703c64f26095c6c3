// SPDX-License-Identifier: Apache-2.0
#include "keep_alive.hpp"

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPeriod{25};

// While a bench connects anew: its watchdog runs.
constexpr milliseconds kRetry{5};

}  // namespace

void KeepAliveSender::start() {
  std::call_once(started_, [this] {
    thread_.start([this] {
      return send();
    });
  });
}

milliseconds KeepAliveSender::send() {
  bool are_all_reached = true;
  for (const BenchKey& key : holdings_.to_keep_alive()) {
    are_all_reached &= connection_.send_keep_alive(key);
  }
  return are_all_reached ? kPeriod : kRetry;
}

}  // namespace vdrive::client
