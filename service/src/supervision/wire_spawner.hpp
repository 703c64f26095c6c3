// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>

namespace vdrive::service {

/// How a wire's process ended. The process may still be there: it runs none of its instructions any
/// more.
struct WireEnd {
  pid_t process = 0;
  int status = 0;  ///< of waitpid
};

/// A small process that starts wires for the engine, so that the engine itself may give away the
/// right to use the network. It is forked before the engine has threads, starts this program with
/// `--wire-process`, and ends with the engine: the kernel kills it, stopped or not, when the thread
/// that made this object ends.
class WireSpawner {
 public:
  /// What the engine tells the spawner, one byte each.
  enum class Order : std::uint8_t { launch, examine, kill };

  /// @param region descriptor that wires inherit
  /// @throws std::system_error
  explicit WireSpawner(int region);
  ~WireSpawner();  ///< kills the wire and ends, within 0.1 s where neither is held
  WireSpawner(const WireSpawner&) = delete;
  WireSpawner& operator=(const WireSpawner&) = delete;

  /// Starts a wire; there is one at a time. @return false when the spawner is gone.
  bool launch() noexcept;

  /// Has the wire's process examined; `next_end` reports when it has ended or is dying. Its end is
  /// reported without this too, as soon as the kernel reports it.
  void examine() const noexcept;

  /// Kills the wire; `next_end` reports its end.
  void kill() const noexcept;

  /// @return the end of a wire since the last call. Does not wait.
  std::optional<WireEnd> next_end() noexcept;

  /// @return whether it has ended, and its wire with it, as `launch` or `next_end` found out: no
  /// wire can be started any more. For the thread that calls those.
  [[nodiscard]] bool is_gone() const noexcept { return is_gone_; }

 private:
  bool order(Order order) const noexcept;

  int socket_ = -1;
  pid_t process_ = 0;
  int descriptor_ = -1;  ///< of the process
  bool is_gone_ = false;
};

}  // namespace vdrive::service
