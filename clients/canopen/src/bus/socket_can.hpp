// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus.hpp"

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

struct can_frame;  // of <linux/can.h>

namespace boost::asio {
class io_context;
}

namespace vdrive::canopen {

/// @return the frame as the kernel's raw CAN sockets take it.
[[nodiscard]] can_frame to_can_frame(const Frame& frame) noexcept;

/// @return the frame that a raw CAN socket gave; nothing for an error message of the controller and
///         for a frame of more than 8 bytes.
[[nodiscard]] std::optional<Frame> from_can_frame(const can_frame& frame) noexcept;

/// What a port calls of the system; a test replaces it.
class CanSockets {
 public:
  virtual ~CanSockets() = default;

  /// @return a socket that does not block.
  /// @throws std::runtime_error as SocketCan::SocketCan() does
  virtual int open(const std::string& interface) = 0;

  /// As read(2) and write(2) of one frame, errno included.
  virtual ssize_t read(int socket, can_frame& frame) = 0;
  virtual ssize_t write(int socket, const can_frame& frame) = 0;
};

/// @return those of the kernel.
[[nodiscard]] CanSockets& kernel_can_sockets() noexcept;

struct SocketCanSettings {
  std::string interface;                   ///< such as "can0"
  std::size_t most_waiting_frames = 4096;  ///< while the interface takes none, at least 1
  /// While that many wait the bus is held until half of them are sent, and none is lost.
  bool holds_bus = false;
  std::chrono::milliseconds reopen_period{1000};  ///< while there is no interface of this name
};

/// What an interface counts since it was opened.
struct SocketCanCounters {
  std::uint64_t received_frames = 0;  ///< from the interface
  std::uint64_t sent_frames = 0;      ///< to the interface
  std::uint64_t dropped_frames = 0;   ///< the oldest that waited, those that were refused, and
                                      ///< those to an interface that is down or gone
  std::uint64_t errors = 0;           ///< of reading and writing, such as an interface that is down
};

/// A CAN interface of the kernel (SocketCAN, CAN_RAW) as a port of a bus: frames of others on the
/// wire come to the bus, frames of the bus go to the wire and to other programs on the interface.
/// Frames to an interface that is down or gone are dropped: late ones would move a drive. One that
/// was unplugged is opened again by its name. For the thread of its context.
class SocketCan final {
 public:
  /// @param context, bus, host, sockets outlive the object
  /// @throws std::runtime_error when the interface cannot be opened, with its name, the reason and
  ///         the next step; a kernel without CAN is one
  SocketCan(boost::asio::io_context& context, Bus& bus, BusHost& host, SocketCanSettings settings,
            CanSockets& sockets = kernel_can_sockets());
  ~SocketCan();
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  [[nodiscard]] const SocketCanCounters& counters() const noexcept;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< an operation of the context that ends later keeps it
};

}  // namespace vdrive::canopen
