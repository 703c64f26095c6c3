// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <shared_mutex>

namespace vdrive::wire {

/// Keeps what the library receives apart from the deletion of a reader or a writer. Fast DDS 2.9
/// and 3.1: a deletion sets the listener to null without a lock, while the library, when it has
/// found an endpoint of another participant, reads the listener three times in a row
/// (EDP::pairing_...). A deletion does not wait for ever on a busy network: who comes after it
/// waits.
class DeletionGate {
 public:
  /// The library may work on what was received while this lives. A thread has one at a time, and
  /// deletes nothing meanwhile.
  [[nodiscard]] std::shared_lock<std::shared_mutex> receive() {
    const std::scoped_lock turn(turn_);
    return std::shared_lock(gate_);
  }

  /// A reader or a writer may be deleted while this lives.
  [[nodiscard]] std::unique_lock<std::shared_mutex> erase() {
    const std::scoped_lock turn(turn_);
    return std::unique_lock(gate_);
  }

 private:
  std::mutex turn_;
  std::shared_mutex gate_;
};

}  // namespace vdrive::wire
