// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/origin.hpp"

#include <pthread.h>
#include <unistd.h>

#include <atomic>

namespace vdrive::wire {
namespace {

/// Number of forks between the first process that created an Origin and this process.
std::atomic<unsigned>& forks() noexcept {
  static std::atomic<unsigned> count{0};
  return count;
}

extern "C" void count_fork() {
  forks().fetch_add(1, std::memory_order_relaxed);
}

unsigned watched_forks() noexcept {
  static const int is_watched = pthread_atfork(nullptr, nullptr, &count_fork);
  static_cast<void>(is_watched);  // if out of memory, a fork is not seen
  return forks().load(std::memory_order_relaxed);
}

}  // namespace

Origin::Origin() : forks_(watched_forks()), process_(getpid()) {}

bool Origin::is_inherited() const noexcept {
  return forks_ != forks().load(std::memory_order_relaxed);
}

std::string Origin::problem(std::string_view what) const {
  return std::string(what) + " belongs to process " + std::to_string(process_) +
         ", from which this one was forked: a forked process cannot use what it inherits. Make the "
         "bench and its sessions in the process that uses them";
}

}  // namespace vdrive::wire
