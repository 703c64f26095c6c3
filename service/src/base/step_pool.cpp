// SPDX-License-Identifier: Apache-2.0
#include "base/step_pool.hpp"

#include "base/relax.hpp"
#include "vdrive/assert.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>

namespace vdrive::service {
namespace {

// Long enough that threads do not sleep between two rounds of a bench in freerun, or while the
// slowest part of a round finishes. A sleeping thread takes 5 to 50 us to wake, and waking it costs
// a system call.
constexpr std::chrono::microseconds kLongestSpin{50};
constexpr int kLooksPerReadingOfTheClock = 64;

/// Waits until `value` is no longer `old`: spins, then sleeps.
std::uint32_t wait_for_change(const std::atomic<std::uint32_t>& value, std::uint32_t old,
                              std::chrono::microseconds longest_spin) noexcept {
  const auto deadline = std::chrono::steady_clock::now() + longest_spin;
  do {
    for (int look = 0; look < kLooksPerReadingOfTheClock; ++look) {
      if (const std::uint32_t now = value.load(std::memory_order_acquire); now != old) return now;
      relax();
    }
  } while (std::chrono::steady_clock::now() < deadline);
  value.wait(old, std::memory_order_acquire);
  return value.load(std::memory_order_acquire);
}

/// @return the processors that this process may use.
std::vector<std::size_t> own_processors() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  std::vector<std::size_t> processors;
  if (sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return processors;
  for (std::size_t processor = 0; processor < CPU_SETSIZE; ++processor) {
    if (CPU_ISSET(processor, &allowed)) processors.push_back(processor);
  }
  return processors;
}

void bind_to(pthread_t thread, std::size_t processor) noexcept {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(processor, &one);
  pthread_setaffinity_np(thread, sizeof(one), &one);
}

}  // namespace

StepPool::StepPool(AxisBank& bank, std::size_t threads)
    : bank_(bank),
      parts_(std::clamp<std::size_t>(threads, 1, bank.group_count())),
      longest_spin_(own_processors().size() < parts_ ? std::chrono::microseconds::zero()
                                                     : kLongestSpin) {
  helpers_.reserve(parts_ - 1);
  for (std::size_t part = 1; part < parts_; ++part) {
    helpers_.emplace_back([this, part] {
      work(part);
    });
  }
}

StepPool::~StepPool() {
  stop_ = true;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (auto& helper : helpers_) helper.join();
}

void StepPool::step() noexcept {
  share(bank_.group_count(), [this](std::size_t first, std::size_t last) {
    bank_.step_groups(first, last);
  });
}

void StepPool::share(const Task& task) noexcept {
  if (parts_ == 1) {
    task.call(task.work, 0, task.count);
    return;
  }
  ensure(unfinished_.load(std::memory_order_relaxed) == 0, "a round begins after the last one");
  task_ = task;
  unfinished_.store(static_cast<std::uint32_t>(parts_ - 1), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  do_part(0);
  std::uint32_t left = unfinished_.load(std::memory_order_acquire);
  while (left != 0) left = wait_for_change(unfinished_, left, longest_spin_);
}

void StepPool::work(std::size_t part) noexcept {
  std::uint32_t round = 0;
  while (true) {
    round = wait_for_change(round_, round, longest_spin_);
    if (stop_) return;
    do_part(part);
    if (unfinished_.fetch_sub(1, std::memory_order_acq_rel) == 1) unfinished_.notify_one();
  }
}

void StepPool::do_part(std::size_t part) const noexcept {
  task_.call(task_.work, task_.count * part / parts_, task_.count * (part + 1) / parts_);
}

void StepPool::schedule_as_caller() noexcept {
  if (parts_ == 1) return;
  int policy = SCHED_OTHER;
  sched_param parameters{};
  if (pthread_getschedparam(pthread_self(), &policy, &parameters) != 0) return;
  const bool is_realtime = policy == SCHED_FIFO || policy == SCHED_RR;
  const auto processors = own_processors();
  const bool has_one_each = is_realtime && processors.size() == parts_;
  if (has_one_each) bind_to(pthread_self(), processors.front());
  for (std::size_t helper = 0; helper < helpers_.size(); ++helper) {
    const pthread_t thread = helpers_[helper].native_handle();
    pthread_setschedparam(thread, policy, &parameters);
    if (has_one_each) bind_to(thread, processors[helper + 1]);
  }
}

}  // namespace vdrive::service
