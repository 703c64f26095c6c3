// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>

namespace vdrive::service {

/// How a wire's process ended. The process may still exist, but executes no instructions any more.
struct WireEnd {
  pid_t process = 0;
  int status = 0;  ///< as waitpid returns it
};

/// A small process that starts wires for the engine, so that the engine itself can give up its
/// network access. It is forked before the engine has threads and starts this program with
/// `--wire-process`. It ends with the engine: the kernel kills it, even if it is stopped, when the
/// thread that created this object ends.
class WireSpawner {
 public:
  /// Orders from the engine to the spawner, one byte each.
  enum class Order : std::uint8_t { launch, examine, kill };

  /// @param region descriptor that wires inherit
  /// @throws std::system_error
  explicit WireSpawner(int region);
  /// Ends wire and spawner, and waits for that for 0.1 s at most. A spawner that is stopped, and a
  /// process that the kernel keeps for a core dump or a debugger, may end later.
  ~WireSpawner();
  WireSpawner(const WireSpawner&) = delete;
  WireSpawner& operator=(const WireSpawner&) = delete;

  /// Starts a wire; there is one at a time. @return false if the spawner is gone.
  bool launch() noexcept;

  /// Has the wire's process examined; `next_end` then reports whether it has ended or is dying.
  /// Needed only for processes that hang in the kernel; other ends are reported without it.
  void examine() const noexcept;

  /// Kills the wire; `next_end` reports its end.
  void kill() const noexcept;

  /// @return the end of a wire since the last call, or nullopt. Does not wait.
  std::optional<WireEnd> next_end() noexcept;

  /// @return whether `launch` or `next_end` found that the spawner has ended, and its wire with it:
  ///         no wire can be started any more. For the thread that calls those functions.
  [[nodiscard]] bool is_gone() const noexcept { return is_gone_; }

 private:
  bool order(Order order) const noexcept;

  int socket_ = -1;
  pid_t process_ = 0;
  int descriptor_ = -1;  ///< pidfd of the process
  bool is_gone_ = false;
};

}  // namespace vdrive::service
