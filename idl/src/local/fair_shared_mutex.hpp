// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <shared_mutex>

namespace vdrive::wire {

/// A shared mutex that gives a thread waiting for exclusive ownership its turn: later shared owners
/// wait. With the shared mutex of the C library, later shared owners overtake the waiting thread,
/// which never gets its turn as long as there is always a shared owner. A thread that shares it
/// must not lock it again. For std::scoped_lock and std::shared_lock.
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
