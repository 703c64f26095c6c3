// SPDX-License-Identifier: Apache-2.0
#include "exchange/keep_alive.hpp"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <utility>

namespace vdrive::client {
namespace {

using std::chrono::milliseconds;

// A small part of the usual time of the watchdog: several keep-alives may be lost or late.
constexpr milliseconds kKeepAlivePeriod{25};

// While a bench connects anew: its watchdog runs.
constexpr milliseconds kRetry{5};

// Where the system forbids a real-time policy: still before programs that compute.
constexpr int kNice = -10;

/// On a busy machine this thread has to run before those that compute. Where the system permits
/// neither it stays as it is.
void raise_priority() {
  const sched_param lowest{.sched_priority = 1};
  if (sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &lowest) == 0) return;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

}  // namespace

void KeepAliveSender::start() {
  // The first axis that is taken starts it: a session that only looks has no such thread.
  std::call_once(started_, [this] {
    thread_.start([this, is_raised = false]() mutable {
      if (!std::exchange(is_raised, true)) raise_priority();
      return send();
    });
  });
}

milliseconds KeepAliveSender::send() {
  bool are_all_reached = true;
  for (const BenchKey& key : holdings_.to_keep_alive()) {
    are_all_reached &= links_.send_keep_alive(key);
  }
  return are_all_reached ? kKeepAlivePeriod : kRetry;
}

}  // namespace vdrive::client
