// SPDX-License-Identifier: Apache-2.0
#include "base/wakeup.hpp"

#include <algorithm>

namespace vdrive::client {
namespace {

/// The interrupts that the current call of this thread survives. Thread-local, because all calls of
/// a session wait in the same objects, but each on its caller's thread.
struct Survived {
  const Wakeup* wakeup = nullptr;
  std::uint64_t interrupts = 0;
};

Survived& survived() {
  thread_local Survived interrupts;
  return interrupts;
}

}  // namespace

Wakeup::StopInProgress::StopInProgress(const Wakeup& wakeup)
    : outer_wakeup_(survived().wakeup), outer_interrupts_(survived().interrupts) {
  if (wakeup.origin_.is_inherited()) return;
  const std::scoped_lock lock(wakeup.mutex_);
  survived() = {.wakeup = &wakeup, .interrupts = wakeup.interrupts_};
}

Wakeup::StopInProgress::~StopInProgress() {
  survived() = {.wakeup = outer_wakeup_, .interrupts = outer_interrupts_};
}

/// Notifies without holding the lock, because a woken thread takes it first.
void Wakeup::notify() {
  {
    const std::scoped_lock lock(mutex_);
    ++changes_;
  }
  changed_.notify_all();
}

void Wakeup::interrupt() noexcept {
  if (origin_.is_inherited()) return;
  const std::scoped_lock lock(mutex_);
  ++interrupts_;
  ++changes_;
  changed_.notify_all();
}

void Wakeup::end_interrupt() noexcept {
  if (origin_.is_inherited()) return;
  const std::scoped_lock lock(mutex_);
  ended_interrupts_ = interrupts_;
}

bool Wakeup::is_interrupted() const {
  if (origin_.is_inherited()) return false;
  const std::scoped_lock lock(mutex_);
  const std::uint64_t survived_here = survived().wakeup == this ? survived().interrupts : 0;
  return interrupts_ > std::max(survived_here, ended_interrupts_);
}

bool Wakeup::is_stopping() const noexcept {
  return survived().wakeup == this;
}

std::uint64_t Wakeup::changes() const {
  const std::scoped_lock lock(mutex_);
  return changes_;
}

Wakeup::Worked Wakeup::work_while(std::uint64_t changes, std::uint32_t bench) {
  Worked worked;
  // Not under the lock: a change made by the work takes it.
  while (work_ && this->changes() == changes) {
    const wire::LocalWork work = work_(bench);
    worked.has_worked |= work == wire::LocalWork::done;
    worked.is_elsewhere = work == wire::LocalWork::elsewhere;
    if (work != wire::LocalWork::done) break;
  }
  return worked;
}

bool Wakeup::work(std::uint64_t changes, std::uint32_t bench) {
  return work_while(changes, bench).has_worked;
}

void Wakeup::work_until(std::uint64_t changes, std::uint32_t bench, Clock::time_point deadline) {
  constexpr std::chrono::milliseconds kPeriod{1};
  const bool is_elsewhere = work_while(changes, bench).is_elsewhere;
  wait_until(changes, is_elsewhere ? std::min(deadline, Clock::now() + kPeriod) : deadline);
}

void Wakeup::wait_until(std::uint64_t changes, Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [&] {
    return changes_ != changes;
  });
}

}  // namespace vdrive::client
