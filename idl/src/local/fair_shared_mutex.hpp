// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <shared_mutex>

namespace vdrive::wire {

/// A shared mutex in which who wants it alone has its turn: who wants to share it after that waits.
/// With the shared mutex of the C library those that share it pass, and as long as there is always
/// one of them, nobody has it alone. No thread may share it twice. For std::scoped_lock and
/// std::shared_lock.
class FairSharedMutex {
 public:
  void lock() {
    turn_.lock();
    shared_.lock();
  }

  void unlock() {
    shared_.unlock();
    turn_.unlock();
  }

  void lock_shared() {
    const std::scoped_lock turn(turn_);
    shared_.lock_shared();
  }

  void unlock_shared() { shared_.unlock_shared(); }

 private:
  std::mutex turn_;
  std::shared_mutex shared_;
};

}  // namespace vdrive::wire
