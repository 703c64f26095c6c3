// SPDX-License-Identifier: Apache-2.0
#include "wakeup.hpp"

namespace vdrive::client {

void Wakeup::notify() {
  const std::scoped_lock lock(mutex_);
  ++changes_;
  changed_.notify_all();
}

void Wakeup::interrupt() noexcept {
  const std::scoped_lock lock(mutex_);
  is_interrupted_ = true;
  ++changes_;
  changed_.notify_all();
}

bool Wakeup::is_interrupted() const {
  const std::scoped_lock lock(mutex_);
  return is_interrupted_;
}

std::uint64_t Wakeup::changes() const {
  const std::scoped_lock lock(mutex_);
  return changes_;
}

void Wakeup::wait_until(std::uint64_t changes, Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [&] {
    return changes_ != changes;
  });
}

}  // namespace vdrive::client
