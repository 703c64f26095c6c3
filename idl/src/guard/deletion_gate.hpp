// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <shared_mutex>

namespace vdrive::wire {

/// Keeps the processing of received data apart from the deletion of readers and writers. Fast DDS
/// 2.9 and 3.1: a deletion sets the listener to null without a lock, while the library, having
/// found an endpoint of another participant, reads the listener three times in succession
/// (EDP::pairing_...). `turn_` keeps a deletion from waiting forever on a busy network: callers
/// that come later wait for it.
class DeletionGate {
 public:
  /// While the returned lock is held, the library may process received data. A thread holds at most
  /// one and deletes nothing while it holds it.
  [[nodiscard]] std::shared_lock<std::shared_mutex> receive() {
    const std::scoped_lock turn(turn_);
    return std::shared_lock(gate_);
  }

  /// While the returned lock is held, a reader or a writer may be deleted.
  [[nodiscard]] std::unique_lock<std::shared_mutex> erase() {
    const std::scoped_lock turn(turn_);
    return std::unique_lock(gate_);
  }

 private:
  std::mutex turn_;
  std::shared_mutex gate_;
};

}  // namespace vdrive::wire
