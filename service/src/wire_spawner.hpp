// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>

namespace vdrive::service {

/// How a wire's process ended.
struct WireEnd {
  pid_t process = 0;
  int status = 0;  ///< of waitpid
};

/// A small process that starts wires for the engine, so that the engine itself may give away the
/// right to use the network. It is forked before the engine has threads, starts this program with
/// `--wire-process`, and ends with the engine.
class WireSpawner {
 public:
  /// @param region descriptor that wires inherit
  /// @throws std::system_error
  explicit WireSpawner(int region);
  ~WireSpawner();  ///< kills the wire and ends
  WireSpawner(const WireSpawner&) = delete;
  WireSpawner& operator=(const WireSpawner&) = delete;

  /// Starts a wire; there is one at a time. @return false when the spawner is gone.
  bool launch() noexcept;

  /// Kills the wire; `next_end` reports its end.
  void kill() const noexcept;

  /// @return the end of a wire since the last call. Does not wait.
  std::optional<WireEnd> next_end() noexcept;

  /// @return whether it has ended, and its wire with it, as `launch` or `next_end` found out: no
  /// wire can be started any more. For the thread that calls those.
  [[nodiscard]] bool is_gone() const noexcept { return is_gone_; }

 private:
  int socket_ = -1;
  pid_t process_ = 0;
  bool is_gone_ = false;
};

}  // namespace vdrive::service
