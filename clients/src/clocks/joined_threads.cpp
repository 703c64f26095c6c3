// SPDX-License-Identifier: Apache-2.0
#include "clocks/joined_threads.hpp"

#include <algorithm>
#include <atomic>

namespace vdrive::client {
namespace {

/// The id of the system is given to a later thread again.
std::uint64_t number_of_this_thread() noexcept {
  static std::atomic<std::uint64_t> last{0};
  thread_local const std::uint64_t number = ++last;
  return number;
}

}  // namespace

Outcome JoinedThreads::join(const Target& target, std::uint64_t session) {
  const std::uint64_t thread = number_of_this_thread();
  const std::scoped_lock lock(mutex_);
  const auto other = std::ranges::find_if(threads_, [&](const auto& joined) {
    return joined.second == thread && joined.first.first == target.key &&
           joined.first.second != session;
  });
  if (other == threads_.end()) {
    threads_[{target.key, session}] = thread;
    return {};
  }
  return Outcome::refused(
      msg::REASON_MISSING_STEPPER,
      "this thread has joined the clock of " + name_of(target) + " already, with session " +
          session_text(other->first.second) +
          ": a step of one of the two would wait for the other for ever; join the clock in the "
          "thread that steps it, or step all benches with one session");
}

void JoinedThreads::leave(const BenchKey& key, std::uint64_t session) {
  const std::scoped_lock lock(mutex_);
  threads_.erase({key, session});
}

JoinedThreads& joined_threads() {
  static JoinedThreads threads;
  return threads;
}

}  // namespace vdrive::client
